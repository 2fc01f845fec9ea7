#pragma once
// How the programs that know only a trace turn its readings into measurements.

#include <vector>

#include "model/files/wire_file.hpp"
#include "observer/measurement.hpp"

namespace smaservo {

/// Keys of --set that are about measuring, with their meaning.
struct MeasurementSetting {
  const char* key;
  const char* meaning;
};
const std::vector<MeasurementSetting>& measurement_settings();

/// What a good front end for this wire would be, with the user's settings on top. Throws UserError
/// for a key that does not exist or a value that is not allowed.
MeasurementParams<double> measuring_params(const Wire<double>& wire,
                                           const std::vector<Override>& settings);

/// Settings for the observers and for measuring, told apart by their table.
struct SplitSettings {
  std::vector<Override> observer, measurement;
};
SplitSettings split_settings(const std::vector<Override>& settings);

}  // namespace smaservo
