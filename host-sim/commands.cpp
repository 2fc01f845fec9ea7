#include "host-sim/commands.hpp"

#include <fmt/format.h>

#include "host-sim/output_file.hpp"

namespace smaservo {

std::vector<Override> parse_settings(const std::vector<std::string>& texts) {
  std::vector<Override> settings;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw UserError(fmt::format("--set {}: must be key=value", text));
    }
    settings.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  return settings;
}

}  // namespace smaservo
