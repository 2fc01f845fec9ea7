#pragma once
// A simulated wire of one temperature, with the observer's own model. It is fast, for tests that do
// not need a wire that differs from the model.

#include <memory>

#include "hal/sim/simulated_wire.hpp"

namespace smaservo::hal {

/// The wire is at rest at 25 °C without load. Its heat loss is that of the wire file times the
/// draught; its hottest point has the single temperature of the wire.
std::unique_ptr<SimulatedWire> make_lumped_wire(const Wire<double>& wire);

}  // namespace smaservo::hal
