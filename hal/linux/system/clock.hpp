#pragma once

#include <cerrno>
#include <cstdint>
#include <ctime>

namespace smaservo::hal {

inline std::int64_t monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

/// Bounds of the lead of CLOCK_BOOTTIME over CLOCK_MONOTONIC, which stands still while the machine
/// is suspended. There are two bounds because the clocks are read one after the other.
struct BootLead {
  std::int64_t min_ns, max_ns;
};

inline BootLead boot_lead() {
  const std::int64_t before_ns = monotonic_ns();
  timespec boot{};
  clock_gettime(CLOCK_BOOTTIME, &boot);
  const std::int64_t boot_ns =
      static_cast<std::int64_t>(boot.tv_sec) * 1'000'000'000 + boot.tv_nsec;
  return {boot_ns - monotonic_ns(), boot_ns - before_ns};
}

/// Measures for how long the machine was suspended.
class SuspendWatch {
 public:
  /// Time suspended since the last call, never overestimated; 0 in the first call.
  std::int64_t suspended_ns(const BootLead& now) {
    const std::int64_t gone_ns = began_ ? now.min_ns - before_ns_ : 0;
    began_ = true;
    before_ns_ = now.max_ns;
    return gone_ns > 0 ? gone_ns : 0;
  }

 private:
  bool began_ = false;
  std::int64_t before_ns_ = 0;
};

/// CLOCK_MONOTONIC with sleeps until absolute times. std::this_thread::sleep_until computes a
/// difference first; an interruption at that point would delay the wake-up.
struct MonotonicClock {
  static std::int64_t now_ns() { return monotonic_ns(); }
  static BootLead boot_lead() { return hal::boot_lead(); }
  static void sleep_until(std::int64_t time_ns) {
    const timespec until{static_cast<std::time_t>(time_ns / 1'000'000'000),
                         static_cast<long>(time_ns % 1'000'000'000)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
  }
};

}  // namespace smaservo::hal
