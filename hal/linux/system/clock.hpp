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

/// CLOCK_MONOTONIC with sleeps to absolute times. std::this_thread::sleep_until computes a
/// difference first; an interruption at that point would make it late.
struct MonotonicClock {
  static std::int64_t now_ns() { return monotonic_ns(); }
  static void sleep_until(std::int64_t time_ns) {
    const timespec until{static_cast<std::time_t>(time_ns / 1'000'000'000),
                         static_cast<long>(time_ns % 1'000'000'000)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
  }
};

}  // namespace smaservo::hal
