#pragma once
// Waits for the time of the loop's next cycle.

#include <cstdint>

#include "hal/linux/system/clock.hpp"

namespace smaservo::daemon {

struct Woke {
  std::int64_t late_ns = 0;  ///< after the cycle's time
  std::uint64_t missed = 0;  ///< cycles whose time passed while the one before still ran
};

/// Cycles begin at multiples of the period after the first wait(). Missed cycles are counted and
/// left out. A clock has now_ns() and sleep_until(ns), both monotonic, and boot_lead().
template <class Clock>
class Pace {
 public:
  static constexpr bool in_time = true;

  explicit Pace(std::int64_t period_ns, Clock clock = {}) : clock_(clock), period_ns_(period_ns) {}

  Woke wait() {
    Woke woke;
    const std::int64_t now_ns = clock_.now_ns();
    if (!began_) {
      began_ = true;
      next_ns_ = now_ns;
    }
    next_ns_ += period_ns_;
    if (next_ns_ <= now_ns) {
      const std::int64_t missed = (now_ns - next_ns_) / period_ns_ + 1;
      woke.missed = static_cast<std::uint64_t>(missed);
      next_ns_ += missed * period_ns_;
    }
    clock_.sleep_until(next_ns_);
    woke.late_ns = clock_.now_ns() - next_ns_;
    return woke;
  }

  /// Real time since the last call, that of a suspended machine included; 0 in the first one.
  std::int64_t gone_ns() {
    const std::int64_t now_ns = clock_.now_ns();
    const std::int64_t suspended_ns = suspend_.suspended_ns(clock_.boot_lead());
    const std::int64_t gone_ns = asked_ ? now_ns - asked_ns_ + suspended_ns : 0;
    asked_ = true;
    asked_ns_ = now_ns;
    return gone_ns;
  }

 private:
  Clock clock_;
  std::int64_t period_ns_;
  std::int64_t next_ns_ = 0;
  bool began_ = false;
  hal::SuspendWatch suspend_;
  std::int64_t asked_ns_ = 0;
  bool asked_ = false;
};

/// For a recording, or a simulation in its own time: the next cycle begins at once.
struct NoPace {
  static constexpr bool in_time = false;  ///< the loop may wait for the recorder

  static Woke wait() { return {}; }
  static std::int64_t gone_ns() { return 0; }
};

}  // namespace smaservo::daemon
