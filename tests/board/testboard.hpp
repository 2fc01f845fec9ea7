#pragma once
// What toolchain/board/module/testboard.c and a program of a test say to each other, and what
// stands between a wire and its ADC.

#include <array>
#include <cmath>
#include <cstdint>

namespace smaservo {

/// Written to /dev/testboard: codes of all channels, of one instant.
struct BoardCodes {
  std::array<std::int32_t, 8> code;
};

/// Read from there. Times are CLOCK_MONOTONIC's.
struct BoardOutput {
  std::uint64_t now_ns;
  std::uint64_t period_ns;
  std::uint64_t duty_ns;       ///< duty time that the user of the PWM has set
  std::uint64_t effective_ns;  ///< duty time that reaches the output
  std::uint64_t changed_ns;    ///< time since which effective_ns is zero, or is not zero
  std::uint64_t kicked_ns;
  std::uint64_t cuts;  ///< number of times that the one-shot has ended heat
};

/// A channel: 2.5 V are 2^bits codes.
struct BoardChannel {
  int bits;
  double per_V, at_0_V;

  std::int32_t code(double value) const {
    return static_cast<std::int32_t>(std::lround(std::ldexp((value - at_0_V) / per_V / 2.5, bits)));
  }
};

namespace board_channels {
inline constexpr BoardChannel current{23, 0.4, 0};    // A
inline constexpr BoardChannel voltage{23, 12, 0};     // V
inline constexpr BoardChannel load{23, 8, 0};         // N
inline constexpr BoardChannel supply{12, 16, 0};      // V
inline constexpr BoardChannel ambient{12, 100, 250};  // K
inline constexpr BoardChannel driver{15, 100, 250};   // K
}  // namespace board_channels

}  // namespace smaservo
