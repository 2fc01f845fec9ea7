#pragma once
// What --set may say of a run besides the wire: of the observer and of measuring.

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
/// By their slots.
const std::vector<RunKey>& run_keys();

/// What is set.
using RunSettings = files::Entries;

/// Whether a key of --set is one of them, and none of the wire's; old names, too.
bool is_run_setting(const std::string& key);

/// Throws ConfigError for a key that does not exist or a value that is not allowed.
RunSettings parse_run_settings(const std::vector<files::Override>& settings);

/// Parameters of either kind with what is set on top.
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
