// All that differs between the targets: SMASERVO_FUZZ names the service.

#include "fuzzed_service.hpp"

namespace smaservo::canopen {

const Service fuzzed_service = Service::SMASERVO_FUZZ;

}  // namespace smaservo::canopen
