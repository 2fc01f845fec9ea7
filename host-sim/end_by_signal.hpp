#pragma once

#include <array>
#include <csignal>

namespace smaservo {

/// While one exists, SIGINT, SIGTERM and SIGHUP, but those that are ignored, are kept until it is
/// destroyed, and end this program then: what it has begun can be left as it should be. The second
/// signal of a kind ends it at once.
class EndBySignal {
 public:
  EndBySignal();
  ~EndBySignal();
  EndBySignal(const EndBySignal&) = delete;
  EndBySignal& operator=(const EndBySignal&) = delete;

  /// Whether one of the signals has come since the newest one began.
  static bool came();

 private:
  std::array<struct sigaction, 3> before_{};
};

}  // namespace smaservo
