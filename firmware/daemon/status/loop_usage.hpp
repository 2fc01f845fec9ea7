#pragma once
// What the loop's thread takes of the machine.

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
    std::optional<double> instructions;  ///< per cycle
  };

  // For the loop's thread.
  void begin();
  /// A thread that has ended can not be asked any more.
  void end() { ask(); }

  // For one other thread.
  bool has_begun() const { return thread_.load(std::memory_order_acquire) != nullptr; }
  /// Now and then; so many turns there have been.
  void look(std::uint64_t cycles);
  Taken taken(std::uint64_t cycles, bool runs);

 private:
  void ask();

  std::unique_ptr<WatchedThread> watched_;
  std::atomic<const WatchedThread*> thread_{nullptr};
  // The other thread's.
  bool counts_ = false;
  PageFaults first_faults_;
  std::uint64_t first_instructions_ = 0, first_cycle_ = 0;
  // Both threads'.
  std::mutex mutex_;
  std::optional<PageFaults> last_faults_;
  std::optional<std::uint64_t> last_instructions_;
};

}  // namespace smaservo::daemon
