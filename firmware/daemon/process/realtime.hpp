#pragma once
// Rights and measures of a real-time thread. What the machine refuses is a warning.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/linux/system/descriptor.hpp"

namespace smaservo::daemon {

struct RealTimeSettings {
  int priority = 80;   ///< of SCHED_FIFO, 1 to 99
  int processor = -1;  ///< to stay on; -1: any
};

/// No page of the process is swapped out, and the heap keeps what it has. Empty, or a warning.
std::string lock_memory();

/// Touches the stack; then SCHED_FIFO for the calling thread, not for those that it starts, on its
/// processor. Warnings.
std::vector<std::string> make_real_time(const RealTimeSettings& settings);

struct PageFaults {
  std::uint64_t minor = 0, major = 0;
};

/// The calling thread, to be watched by another one.
class WatchedThread {
 public:
  /// The calling thread.
  WatchedThread();

  /// Since it began.
  std::optional<PageFaults> page_faults() const;
  /// Instructions of the program, not the kernel's; nothing where the machine does not count them.
  std::optional<std::uint64_t> instructions() const;

 private:
  int thread_;
  hal::Descriptor counter_;
};

}  // namespace smaservo::daemon
