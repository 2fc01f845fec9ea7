#pragma once
// Converts between the node's clock, which counts microseconds, and seconds, without 64-bit
// conversions, which a microcontroller would have to do in software in double precision.

#include <algorithm>
#include <cstdint>

namespace smaservo::canopen {

/// Times longer than 71 minutes give 71 minutes.
constexpr float seconds_of(std::uint64_t us) {
  constexpr std::uint64_t max = 0xFFFF'FFFF;
  return 1e-6F * static_cast<float>(static_cast<std::uint32_t>(std::min(us, max)));
}

/// Wraps after 49 days. The division is written out, since a library's 64-bit division needs up to
/// 700 bytes.
constexpr std::uint32_t milliseconds_of(std::uint64_t us) {
  constexpr std::uint32_t by = 1000;
  std::uint32_t rest = static_cast<std::uint32_t>(us >> 32U) % by;
  std::uint32_t ms = 0;
  for (const unsigned shift : {16U, 0U}) {
    const std::uint32_t part = rest << 16U | (static_cast<std::uint32_t>(us) >> shift & 0xFFFFU);
    ms = ms << 16U | part / by;
    rest = part % by;
  }
  return ms;
}

/// `s` must be within 0 and 4e9.
constexpr std::uint64_t microseconds_of(float s) {
  const auto whole = static_cast<std::uint32_t>(s);
  const float rest = s - static_cast<float>(whole);
  return std::uint64_t{whole} * 1'000'000 + static_cast<std::uint32_t>(1e6F * rest);
}

}  // namespace smaservo::canopen
