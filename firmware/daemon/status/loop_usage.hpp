#pragma once
// The machine's resources that the loop's thread uses.

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

#include "firmware/daemon/process/realtime.hpp"

namespace smaservo::daemon {

/// Page faults and instructions of the loop's thread, without its first cycles.
class LoopUsage {
 public:
  struct Taken {
    std::optional<PageFaults> page_faults;
    std::optional<double> instructions;  ///< instructions per cycle
  };

  // Called by the loop's thread.
  void begin();
  /// Reads the counters for the last time, since those of a thread that has ended cannot be read.
  void end() { ask(); }

  // Called by one other thread.
  bool has_begun() const { return thread_.load(std::memory_order_acquire) != nullptr; }
  /// To be called from time to time, with the number of cycles so far.
  void look(std::uint64_t cycles);
  Taken taken(std::uint64_t cycles, bool runs);

 private:
  void ask();

  std::unique_ptr<WatchedThread> watched_;
  std::atomic<const WatchedThread*> thread_{nullptr};
  // Used only by the other thread.
  bool counts_ = false;
  PageFaults first_faults_;
  std::uint64_t first_instructions_ = 0, first_cycle_ = 0;
  // Used by both threads.
  std::mutex mutex_;
  std::optional<PageFaults> last_faults_;
  std::optional<std::uint64_t> last_instructions_;
};

}  // namespace smaservo::daemon
