#pragma once
// How the programs that know only a trace turn its readings into measurements.

#include "host-sim/replay/run_settings.hpp"
#include "model/wire/wire.hpp"
#include "observer/measurement.hpp"

namespace smaservo::replay {

/// What a good front end for this wire would be, with the user's settings on top.
MeasurementParams<double> measuring_params(const Wire<double>& wire, const RunSettings& settings);

}  // namespace smaservo::replay
