#pragma once
// Runs a scenario on a plant that no observer knows: distributed temperature, cold clamps, scatter
// along the wire, convection after Churchill and Chu, noisy and quantised sensors.

#include "host-sim/output_file.hpp"
#include "host-sim/scenario.hpp"

namespace smaservo {

/// Writes the trace; the same scenario gives the same trace.
void simulate(const Scenario& scenario, OutputFile& trace);

}  // namespace smaservo
