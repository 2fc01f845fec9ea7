#pragma once

#include "tests/firmware/canopen/service.hpp"

namespace smaservo::canopen {

/// Of this target.
extern const Service fuzzed_service;

}  // namespace smaservo::canopen
