#pragma once
// The keys that a proposal sets, each with its reason.

#include <string>
#include <vector>

#include "firmware/settings.hpp"

namespace smaservo::tune {

struct Chosen {
  const char* table;  ///< table of the settings file, such as "strain"
  const char* key;    ///< key in that table, such as "dead_band"
  double value;
  const char* why;

  std::string path() const { return std::string(table) + "." + key; }
};

/// The chosen keys in the order of a settings file, without those of loops that are not possible.
std::vector<Chosen> chosen_settings(const Settings<double>& settings, bool resistance, bool force);

/// The keys as a part of a settings file, with their reasons as comments.
std::string chosen_toml(const std::vector<Chosen>& chosen, const std::string& heading);

}  // namespace smaservo::tune
