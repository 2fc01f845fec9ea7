#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace smaservo::test {

/// As RFC 4648 says.
inline std::string from_base64(const std::string& text) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::size_t bits = 0;
  unsigned count = 0;
  for (const char c : text.substr(0, text.find('='))) {
    bits = (bits << 6U | digits.find(c)) & 0xFFFFU;
    count += 6;
    if (count < 8) {
      continue;
    }
    count -= 8;
    bytes += static_cast<char>(bits >> count & 0xFFU);
  }
  return bytes;
}

}  // namespace smaservo::test
