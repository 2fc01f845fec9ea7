#pragma once
// Wire descriptions: TOML files with geometry, limits, model parameters and where each number comes
// from. The presets of model/wires are built into the program. model/wires/README.md has the keys.

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/wire/wire.hpp"

namespace smaservo {

/// What is wrong with a description: names file, key, value and what is allowed.
class WireError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct WireDescription {
  std::string name;
  Wire<double> wire;
  /// Where the numbers come from, by key or group of keys.
  std::vector<std::pair<std::string, std::string>> sources;
};

/// "wire.length_m", "0.12": replaces a key of the file, in any unit of its kind.
using Override = std::pair<std::string, std::string>;

/// A preset's name or the path of a file that ends in ".toml". Throws WireError.
WireDescription load_wire(const std::string& name_or_path,
                          const std::vector<Override>& overrides = {});

/// The same from text; `origin` is what error messages call it. A relative `based_on` is looked for
/// in `folder`.
WireDescription parse_wire(std::string_view text, const std::string& origin,
                           const std::vector<Override>& overrides = {},
                           const std::filesystem::path& folder = ".");

/// Names of the presets, sorted.
std::vector<std::string> preset_names();

inline constexpr std::string_view default_wire = "smartflex-76um";

/// A complete description as TOML that load_wire() reads back to the same numbers.
std::string to_toml(const WireDescription& description);

}  // namespace smaservo
