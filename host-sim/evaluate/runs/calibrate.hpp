#pragma once
// The wire of a unit as `host-sim identify` would find it from the unit's calibration runs.

#include <functional>
#include <string>

#include "firmware/bench/scenario/units.hpp"
#include "host-sim/identify/fit/fit.hpp"
#include "host-sim/identify/runs/run.hpp"

namespace smaservo::evaluate {

/// One of the unit's calibration runs, as a bench would record it. The stress is computed with the
/// wire's nominal diameter.
identify::Run calibration_measurement(const bench::WireUnit& unit, std::size_t index);

/// Fits the wire to all calibration_runs, starting from the unit's type file; one thread. Takes
/// about a minute. Ends early, with a wire that is not fitted, when `proceed` returns false, which
/// it asks many times.
files::WireDescription calibrate(
    const bench::WireUnit& unit, const std::function<bool()>& proceed = [] { return true; },
    identify::Structure structure = identify::Structure::automatic);

/// Like calibrate(), with a folder that keeps the wires: a wire in it is read, another one is
/// calibrated and written. An empty name keeps nothing. Throws UserError.
Wire<double> calibrated_wire(const bench::WireUnit& unit, const std::string& folder,
                             identify::Structure structure = identify::Structure::automatic);

/// The file name of a unit's calibrated wire, such as "ihyp-1000.toml" or "ihyp-1000-ordered.toml".
std::string calibrated_name(hal::Family family, std::uint64_t seed,
                            identify::Structure structure = identify::Structure::automatic);

}  // namespace smaservo::evaluate
