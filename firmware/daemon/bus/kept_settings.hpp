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

/// Reads the settings from the store in this folder; where it has none, takes `otherwise`. A store
/// that can not be read back whole is a fault. `configured` says that `otherwise` is meant for this
/// wire.
KeptSettings keep_settings(const std::string& folder, const Settings<double>& otherwise,
                           bool configured);

/// Writes the settings to the store in this folder. Returns what went wrong; empty: nothing.
std::string store_settings(const std::string& folder, const Settings<double>& settings);

/// Erases the store in this folder. Returns what went wrong; empty: nothing.
std::string forget_settings(const std::string& folder);

}  // namespace smaservo::daemon
