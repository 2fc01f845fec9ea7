#pragma once
// Texts and numbers of a microcontroller's test, over semihosting.

#include <array>
#include <charconv>
#include <cmath>
#include <concepts>

#include "hal/cortex-m/semihosting.hpp"

namespace smaservo::mcu {

inline void put(std::string_view text) {
  semihosting::print(text);
}

inline void put(std::integral auto number) {
  std::array<char, 24> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  put(std::string_view(text.data(), end));
}

/// Three digits and a power of ten.
inline void put(float number) {
  if (!std::isfinite(number)) {
    put(std::string_view("not finite"));
    return;
  }
  int power = 0;
  float size = std::abs(number);
  while (size != 0 && size < 1) {
    size *= 10;
    --power;
  }
  while (10 <= size) {
    size /= 10;
    ++power;
  }
  const auto digits = static_cast<int>(size * 100 + 0.5F);
  put(std::string_view(number < 0 ? "-" : ""));
  put(digits / 100);
  put(std::string_view("."));
  put(digits / 10 % 10);
  put(digits % 10);
  put(std::string_view("e"));
  put(power);
}

template <class... T>
void say(const T&... parts) {
  (put(parts), ...);
}

}  // namespace smaservo::mcu
