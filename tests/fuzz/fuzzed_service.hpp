#pragma once

#include "tests/firmware/canopen/node/service.hpp"

namespace smaservo::canopen {

/// The service that this fuzz target tests.
extern const Service fuzzed_service;

}  // namespace smaservo::canopen
