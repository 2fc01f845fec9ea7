#pragma once

#include <string>

#include "host-sim/simulate/closed_loop_run.hpp"
#include "host-sim/units.hpp"

namespace smaservo::simulate {

/// Writes one HTML file that can be opened without a network: numbers, plots, the device's faults.
/// If the result has no record, there are no plots. Throws UserError.
void write_report(const std::string& path, const bench::ClosedLoopScenario& scenario,
                  const LoopRunResult& result, Units units);

}  // namespace smaservo::simulate
