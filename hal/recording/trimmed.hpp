#pragma once

#include <string_view>

namespace smaservo::hal {

/// The text without the blanks and tabs around it.
inline std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t";
  const std::size_t from = text.find_first_not_of(blanks);
  return from == std::string_view::npos
             ? std::string_view()
             : text.substr(from, text.find_last_not_of(blanks) - from + 1);
}

}  // namespace smaservo::hal
