#pragma once

#include "tests/firmware/canopen/node/service.hpp"

namespace smaservo::canopen {

/// Of this target.
extern const Service fuzzed_service;

}  // namespace smaservo::canopen
