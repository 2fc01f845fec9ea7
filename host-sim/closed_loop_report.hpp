#pragma once

#include <string>

#include "host-sim/closed_loop_run.hpp"

namespace smaservo {

/// Writes one HTML file that opens without a network: numbers, plots, the device's faults. The
/// result must have a record. Throws UserError.
void write_report(const std::string& path, const ClosedLoopScenario& scenario,
                  const LoopRunResult& result);

}  // namespace smaservo
