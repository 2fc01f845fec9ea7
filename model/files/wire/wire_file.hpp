#pragma once
// Wire descriptions: TOML files with geometry, limits, model parameters and where each number comes
// from. The presets of model/wires are built into the program. model/wires/README.md has the keys.

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/files/toml/fields.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::files {

/// What a wire file says.
struct WireDescription {
  std::string name;
  Wire<double> wire;
  /// The sources of the numbers, by key or group of keys.
  std::vector<std::pair<std::string, std::string>> sources;
};

/// A preset's name or the path of a file that ends in ".toml". Throws ConfigError.
WireDescription load_wire(const std::string& name_or_path,
                          const std::vector<Override>& overrides = {});

/// Like load_wire(), from text; `origin` names it in error messages. A relative `based_on` is
/// looked for in `folder`.
WireDescription parse_wire(std::string_view text, const std::string& origin,
                           const std::vector<Override>& overrides = {},
                           const std::filesystem::path& folder = ".");

/// Names of the presets, sorted.
std::vector<std::string> preset_names();

inline constexpr std::string_view default_wire = "smartflex-76um";

/// A complete description as TOML that load_wire() reads back to the same numbers.
std::string to_toml(const WireDescription& description);
/// The same with all numbers in SI, for programs: the keys do not depend on the values.
std::string to_toml_si(const WireDescription& description);

}  // namespace smaservo::files
