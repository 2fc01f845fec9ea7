#pragma once
// The keys of --set that are not the wire's: those of the observer and of measurement.

#include <string>
#include <variant>
#include <vector>

#include "model/files/toml/fields.hpp"
#include "observer/measurement.hpp"

namespace smaservo {
template <class S>
struct KalmanTuning;
}  // namespace smaservo

namespace smaservo::replay {

/// A key and the member that it sets.
struct RunKey {
  files::Field field;
  std::variant<double KalmanTuning<double>::*, double MeasurementParams<double>::*> member;
};
/// In the order of their slots.
const std::vector<RunKey>& run_keys();

/// The keys that --set has given, with their values.
using RunSettings = files::Entries;

/// Whether a key of --set, by its present or an old name, is one of these rather than one of the
/// wire's.
bool is_run_setting(const std::string& key);

/// Throws ConfigError for a key that does not exist or a value that is not allowed.
RunSettings parse_run_settings(const std::vector<files::Override>& settings);

/// `params` of the observer or of measurement, changed by the settings.
template <class Params>
Params with_settings(Params params, const RunSettings& settings) {
  for (const auto& [slot, entry] : settings) {
    if (const auto* member = std::get_if<double Params::*>(&run_keys()[slot].member)) {
      params.** member = entry.number;
    }
  }
  return params;
}

}  // namespace smaservo::replay
