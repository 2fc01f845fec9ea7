#pragma once
// Memory, priority and counters of a real-time thread. A request that the machine refuses becomes a
// warning.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/linux/system/descriptor.hpp"

namespace smaservo::daemon {

struct RealTimeSettings {
  int priority = 80;   ///< priority in SCHED_FIFO, 1 to 99
  int processor = -1;  ///< processor to run on; -1: any
};

/// Sets the name of the calling thread, as `top -H` and /proc show it. A name of more than 15
/// characters has no effect. Must be called before allow_loop_calls_only(), which forbids it.
void name_thread(const char* name);

/// Keeps all pages of the process in memory, and freed memory in the heap. Returns a warning, or an
/// empty text.
std::string lock_memory();

/// Touches the stack, then sets the processor of the calling thread and SCHED_FIFO, which threads
/// started by it do not inherit. Returns warnings.
std::vector<std::string> make_real_time(const RealTimeSettings& settings);

struct PageFaults {
  std::uint64_t minor = 0, major = 0;
};

/// Page faults and instructions of one thread, read by another one.
class WatchedThread {
 public:
  /// Watches the calling thread.
  WatchedThread();

  /// Page faults since the thread began.
  std::optional<PageFaults> page_faults() const;
  /// Instructions of the program without those of the kernel; nothing if the machine does not count
  /// them.
  std::optional<std::uint64_t> instructions() const;

 private:
  int thread_;
  hal::Descriptor counter_;
};

}  // namespace smaservo::daemon
