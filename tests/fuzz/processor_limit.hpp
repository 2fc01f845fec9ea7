#pragma once
// The longest time that one input may take, in seconds of the processor. The limit of libFuzzer
// itself, -timeout, counts the clock: where the machine has other work of a higher priority, as
// beside the real-time tests, an input of 5 ms may take many seconds of it.

#include <csignal>
#include <cstdlib>
#include <sys/time.h>

namespace smaservo::fuzz {

/// Aborts while one input lives for too long; libFuzzer then keeps the input, as for a crash.
class ProcessorLimit {
 public:
  ProcessorLimit() {
    std::signal(SIGPROF, [](int /*signal*/) { std::abort(); });
    arm(longest_s);
  }
  ~ProcessorLimit() { arm(0); }
  ProcessorLimit(const ProcessorLimit&) = delete;
  ProcessorLimit& operator=(const ProcessorLimit&) = delete;

 private:
  static constexpr time_t longest_s = 10;

  static void arm(time_t seconds) {
    const itimerval once{.it_interval = {}, .it_value = {.tv_sec = seconds, .tv_usec = 0}};
    if (setitimer(ITIMER_PROF, &once, nullptr) != 0) {
      std::abort();
    }
  }
};

}  // namespace smaservo::fuzz
