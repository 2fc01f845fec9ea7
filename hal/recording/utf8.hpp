#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace smaservo::hal {

/// Appends a character, given by its code point (up to 10FFFFh, no surrogate), as UTF-8.
inline void put_utf8(std::string& to, std::uint32_t code) {
  const auto byte = [&](std::uint32_t value) { to += static_cast<char>(value); };
  if (code < 0x80) {
    byte(code);
  } else if (code < 0x800) {
    byte(0xC0 | code >> 6U);
    byte(0x80 | (code & 0x3FU));
  } else if (code < 0x10000) {
    byte(0xE0 | code >> 12U);
    byte(0x80 | (code >> 6U & 0x3FU));
    byte(0x80 | (code & 0x3FU));
  } else {
    byte(0xF0 | code >> 18U);
    byte(0x80 | (code >> 12U & 0x3FU));
    byte(0x80 | (code >> 6U & 0x3FU));
    byte(0x80 | (code & 0x3FU));
  }
}

/// The number of bytes that follow a character's first one; -1 where no character begins so.
constexpr int utf8_bytes_after(unsigned char first) {
  return first < 0x80   ? 0
         : first < 0xC2 ? -1
         : first < 0xE0 ? 1
         : first < 0xF0 ? 2
         : first < 0xF5 ? 3
                        : -1;
}

/// Whether each byte above 7Fh belongs to a character of two to four bytes.
inline bool is_utf8(std::string_view text) {
  int expected = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool continues = 0x80 <= byte && byte < 0xC0;
    if (continues != (expected > 0)) {
      return false;
    }
    expected = continues ? expected - 1 : utf8_bytes_after(byte);
    if (expected < 0) {
      return false;
    }
  }
  return expected == 0;
}

/// The text in UTF-8; one that is not is taken for Latin-1, where a byte is a character.
inline std::string utf8_of(std::string_view text) {
  if (is_utf8(text)) {
    return std::string(text);
  }
  std::string utf8;
  for (const char c : text) {
    put_utf8(utf8, static_cast<unsigned char>(c));
  }
  return utf8;
}

}  // namespace smaservo::hal
