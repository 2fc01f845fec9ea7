#pragma once
// Measurement parameters for programs that know nothing of the board that recorded a trace.

#include "host-sim/replay/run_settings.hpp"
#include "model/wire/wire.hpp"
#include "observer/measurement.hpp"

namespace smaservo::replay {

/// The parameters of a good front end for this wire, changed by the user's settings.
MeasurementParams<double> measurement_params(const Wire<double>& wire, const RunSettings& settings);

}  // namespace smaservo::replay
