#pragma once

#include <string>

#include "firmware/faults.hpp"
#include "firmware/settings.hpp"

namespace smaservo::daemon {

/// Which settings a run begins with, and why.
struct KeptSettings {
  Settings<double> settings;
  FaultSet faults;   ///< not_configured, store_corrupt
  std::string said;  ///< one sentence for the log
};

/// Those of the store in this folder; where it has none, those of `otherwise`. A store that is
/// there but can not be read back whole is a fault. `configured`: `otherwise` is meant for this
/// wire.
KeptSettings keep_settings(const std::string& folder, const Settings<double>& otherwise,
                           bool configured);

/// Writes them to the store in this folder. Empty, or what went wrong.
std::string store_settings(const std::string& folder, const Settings<double>& settings);

/// Leaves the store empty. Empty, or what went wrong.
std::string forget_settings(const std::string& folder);

}  // namespace smaservo::daemon
