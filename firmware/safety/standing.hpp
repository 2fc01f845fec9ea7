#pragma once
// Warnings as they are reported: each stands for at least a second after its cause, and how often
// the cause has come is counted. A limiter acts on the cause itself, which may come and go a
// hundred times a second: it reduces the current, and the reduced current ends it.

#include <array>
#include <bit>

#include "firmware/safety/failsafe.hpp"

namespace smaservo {

/// The faults that may be warnings: those that end no heat.
inline constexpr FaultSet warning_faults =
    limiting_faults | faults_of(FaultClass::B) | faults_of(FaultClass::W);
static_assert(std::popcount(warning_faults.bits()) == warning_count);

/// The place of a warning in WarningCounts; only for faults of warning_faults.
constexpr std::size_t warning_index(Fault fault) {
  const std::uint64_t below = (std::uint64_t{1} << static_cast<unsigned>(fault)) - 1;
  return static_cast<std::size_t>(std::popcount(warning_faults.bits() & below));
}

/// All zero: there has been no warning. A condition that blocks while the device is off and warns
/// while it is on comes anew each time.
template <class S>
struct StandingWarnings {
  static constexpr S stands_s = S(1);

  FaultSet present;   ///< causes in the last step
  FaultSet standing;  ///< warnings to be reported
  std::array<S, warning_count> left_s;
  WarningCounts came;
  std::uint8_t turn;

  /// `now`: warnings whose cause is present in this step, a part of warning_faults. `clear` ends
  /// those whose cause has gone. Cost: some operations for each warning that stands; otherwise next
  /// to nothing.
  FaultSet step(FaultSet now, bool clear, const S& dt_s) {
    for_each_fault(now | standing, [&](Fault fault) {
      const std::size_t i = warning_index(fault);
      if (now.has(fault)) {
        came[i] += present.has(fault) ? 0U : 1U;
        left_s[i] = stands_s;
        standing.set(fault);
        return;
      }
      left_s[i] -= dt_s;
      if (clear || !(S(0) < left_s[i])) {
        standing.set(fault, false);
      }
    });
    present = now;
    turn = turn + 1U < warning_count ? static_cast<std::uint8_t>(turn + 1U) : std::uint8_t{0};
    return standing;
  }
  /// The count whose turn it is.
  WarningCount told() const { return {turn, came[turn]}; }
};

}  // namespace smaservo
