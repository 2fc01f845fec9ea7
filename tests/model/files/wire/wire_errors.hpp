#pragma once

#include <gmock/gmock.h>
#include <string>
#include <vector>

#include "model/files/error.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::files {

/// What a description is refused with; empty where it is accepted.
inline std::string refusal(const std::string& text, const std::vector<Override>& overrides = {}) {
  try {
    parse_wire(text, "my.toml", overrides);
    return {};
  } catch (const ConfigError& error) {
    return error.what();
  }
}

/// A description on top of the default wire.
inline std::string own_wire(const std::string& lines) {
  return "based_on = \"smartflex-76um\"\n" + lines + "\n";
}

/// Matches a text that contains all the parts.
inline auto names(const std::vector<std::string>& parts) {
  std::vector<testing::Matcher<std::string>> all;
  all.reserve(parts.size());
  for (const std::string& part : parts) {
    all.emplace_back(testing::HasSubstr(part));
  }
  return testing::AllOfArray(all);
}

}  // namespace smaservo::files
