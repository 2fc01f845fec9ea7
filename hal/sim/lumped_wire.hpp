#pragma once
// A simulated wire of one temperature: the observer's own model, for speed and for what does not
// ask how a wire differs from it.

#include <memory>

#include "hal/sim/simulated_wire.hpp"

namespace smaservo::hal {

/// At rest at 25 °C without load. Its loss is the wire file's, times the draught; the hottest point
/// is the one temperature.
std::unique_ptr<SimulatedWire> make_lumped_wire(const Wire<double>& wire);

}  // namespace smaservo::hal
