#pragma once

#include <string>
#include <vector>

#include "firmware/faults.hpp"
#include "firmware/parameters/key.hpp"
#include "firmware/settings.hpp"

namespace smaservo::daemon {

/// A parameter whose value in a bad slot of the store differs from the one in force.
struct LostValue {
  Key key;
  std::uint32_t stored, in_force;  ///< bits as sent
};

/// The settings with which a run begins, and where they come from.
struct KeptSettings {
  Settings<double> settings;
  FaultSet faults;                ///< not_configured, store_corrupt, store_outdated
  std::vector<std::string> said;  ///< lines for the log; more than one if the store has a fault
  std::vector<LostValue> lost;
};

/// Reads the settings from the store in this folder; if it has none, takes `otherwise`. A store
/// that cannot be read back completely is a fault, even if it still has older settings: these are
/// then in force, and `lost` has the newer values that a bad slot still contains. `configured` says
/// that `otherwise` is meant for this wire.
KeptSettings keep_settings(const std::string& folder, const Settings<double>& otherwise,
                           bool configured);

/// Writes the settings to the store in this folder. Returns the error; empty if there is none.
std::string store_settings(const std::string& folder, const Settings<double>& settings);

/// Whether a start would take its settings from the store in this folder.
bool has_settings(const std::string& folder);

/// Erases the store in this folder. Returns the error; empty if there is none.
std::string forget_settings(const std::string& folder);

}  // namespace smaservo::daemon
