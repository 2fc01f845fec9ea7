#pragma once

#include <span>
#include <string_view>

namespace smaservo::files {

/// One .toml file of model/wires: an alloy with its sizes.
struct Preset {
  std::string_view family;
  std::string_view text;
};

std::span<const Preset> presets();

}  // namespace smaservo::files
