#pragma once
// The servos of a bus, as a source.

#include <memory>
#include <string>

#include "host-sim/page/source.hpp"

namespace smaservo::page {

/// Opens a CAN interface by its name. Throws UserError.
std::unique_ptr<Source> make_servo_source(const std::string& can);

}  // namespace smaservo::page
