#pragma once
// The lines of the log about warnings of the device. The cause of one may come a hundred times a
// second, so that a warning is told when it first comes, and then at most once a minute with the
// number of times.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/faults.hpp"

namespace smaservo::daemon {

class WarningJournal {
 public:
  static constexpr std::uint64_t quiet_us = 60'000'000;

  /// The lines that are due at this time of the loop, often none. `all` are the device's own
  /// counts, so it does not matter how often this is called. A time earlier than the last one is
  /// that of a device that has started anew.
  std::vector<std::string> lines(std::uint64_t time_us, const WarningCounts& all);

 private:
  struct Told {
    std::uint32_t causes = 0;  ///< 0: the warning has not been told
    std::uint64_t time_us = 0;
  };
  std::array<Told, warning_count> told_{};
  std::uint64_t time_us_ = 0;
};

}  // namespace smaservo::daemon
