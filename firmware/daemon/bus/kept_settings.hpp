#pragma once

#include <string>
#include <vector>

#include "firmware/faults.hpp"
#include "firmware/parameters/key.hpp"
#include "firmware/settings.hpp"

namespace smaservo::daemon {

/// A parameter that a bad slot of the store has with another value than the one in force.
struct LostValue {
  Key key;
  std::uint32_t stored, in_force;  ///< bits, as they are sent
};

/// Which settings a run begins with, and why.
struct KeptSettings {
  Settings<double> settings;
  FaultSet faults;                ///< not_configured, store_corrupt, store_outdated
  std::vector<std::string> said;  ///< lines for the log; more than one if the store has a fault
  std::vector<LostValue> lost;
};

/// Reads the settings from the store in this folder; where it has none, takes `otherwise`. A store
/// that cannot be read back whole is a fault, also where it still has older settings: then those
/// are in force, and `lost` has what a bad slot still says of newer ones. `configured` says that
/// `otherwise` is meant for this wire.
KeptSettings keep_settings(const std::string& folder, const Settings<double>& otherwise,
                           bool configured);

/// Writes the settings to the store in this folder. Returns what went wrong; empty: nothing.
std::string store_settings(const std::string& folder, const Settings<double>& settings);

/// Whether a start would take its settings from the store in this folder.
bool has_settings(const std::string& folder);

/// Erases the store in this folder. Returns what went wrong; empty: nothing.
std::string forget_settings(const std::string& folder);

}  // namespace smaservo::daemon
