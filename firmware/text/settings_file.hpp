#pragma once
// Device settings as TOML. Keys are the paths of firmware/parameters/parameters.hpp, in any unit of
// their kind; what is left out has its default. [wire] has the keys of a wire file
// (model/wires/README.md), below a preset, a wire file, or as a whole wire:
//
//   [wire]
//   based_on = "smartflex-76um"     # also: wire = "smartflex-76um", where nothing is replaced
//   length_mm = 182                 # replaces this number; nothing else follows from it
//
//   [limits]
//   current_mA = 150
//   temperature_degC = 110
//
// Values are rounded to float, so that the store, CAN and a file give the same device.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/parameters/parameter_check.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::text {

/// Reads settings with a wire that pass check(). `overrides` are those of the command line, such as
/// "limits.current_mA", "120". Throws ConfigError, which names file, line, key, value and what is
/// allowed.
Settings<double> load_settings_file(const std::string& path,
                                    const std::vector<files::Override>& overrides = {});

/// The same from a text, which messages call `origin`. A wire file is looked for in `folder`.
Settings<double> parse_settings_file(std::string_view text, const std::string& origin,
                                     const std::vector<files::Override>& overrides = {},
                                     const std::filesystem::path& folder = ".");

/// Splits the "key=value" texts of --set. Throws ConfigError.
std::vector<files::Override> parse_settings(const std::vector<std::string>& texts);

/// A settings file with every parameter in SI; it reads back to the same floats. The settings must
/// have a wire.
std::string to_toml(const Settings<double>& settings);

/// A settings file to start from: settings_for() this wire, each key explained.
std::string settings_template(const std::string& wire);

/// The default settings, with the limits that the wire's maker states.
Settings<double> settings_for(const Wire<double>& wire);

}  // namespace smaservo::text
