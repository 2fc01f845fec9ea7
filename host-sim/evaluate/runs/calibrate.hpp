#pragma once
// A unit's wire as `host-sim identify` would find it from its calibration runs.

#include <string>

#include "firmware/bench/scenario/units.hpp"
#include "host-sim/identify/runs/run.hpp"

namespace smaservo::evaluate {

/// One of the unit's calibration runs, as a bench would record it. The stress is that of the wire's
/// nominal diameter.
identify::Run calibration_measurement(const bench::WireUnit& unit, std::size_t index);

/// Fits the wire to all calibration_runs, from the unit's type file on; one thread. Takes about a
/// minute.
files::WireDescription calibrate(const bench::WireUnit& unit);

/// The same with a folder that keeps the wires: a wire that is in it is read, another one is
/// calibrated and written. An empty name keeps nothing. Throws UserError.
Wire<double> calibrated_wire(const bench::WireUnit& unit, const std::string& folder);

/// "ihyp-1000.toml": the file of a unit's calibrated wire.
std::string calibrated_name(hal::Family family, std::uint64_t seed);

}  // namespace smaservo::evaluate
