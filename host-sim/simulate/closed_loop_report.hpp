#pragma once

#include <string>

#include "host-sim/simulate/closed_loop_run.hpp"

namespace smaservo::simulate {

/// Writes one HTML file that opens without a network: numbers, plots, the device's faults. Without
/// a record in the result there are no plots. Throws UserError.
void write_report(const std::string& path, const bench::ClosedLoopScenario& scenario,
                  const LoopRunResult& result);

}  // namespace smaservo::simulate
