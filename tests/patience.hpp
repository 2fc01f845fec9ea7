#pragma once
// The one patience of all live tests: they wait for events, and only a program that hangs takes so
// long.

#include <chrono>
#include <thread>

namespace smaservo::test {

inline constexpr std::chrono::minutes patience{10};

/// Waits until the condition holds, and looks no second time: it may hold once only.
template <class Condition>
bool becomes(Condition condition) {
  const auto until = std::chrono::steady_clock::now() + patience;
  do {
    if (condition()) {
      return true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  } while (std::chrono::steady_clock::now() < until);
  return false;
}

}  // namespace smaservo::test
