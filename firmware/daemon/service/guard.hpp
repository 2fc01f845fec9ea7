#pragma once
// The lease again, in software: where the loop hangs, in a device's driver as well, its outputs
// still go off. What stops the whole program only the hardware's one-shot answers.

#include <atomic>
#include <optional>
#include <thread>
#include <vector>

#include "firmware/daemon/process/realtime.hpp"
#include "hal/linux/system/off_action.hpp"

namespace smaservo::daemon {

/// While it lives, a thread of its own looks at the lease every 2 ms.
class LeaseGuard {
 public:
  /// `loop`: the loop's rights, where it has some; the guard's are those above. The outputs, the
  /// lease (LoopLinks::lease_ends_ns) and the count of times that they had to be switched off
  /// outlive it.
  LeaseGuard(const std::vector<hal::OffAction>& off, const std::optional<RealTimeSettings>& loop,
             const std::atomic<std::int64_t>& lease_ends_ns, std::atomic<std::uint64_t>& stops);

 private:
  void run(const std::stop_token& stop) const;

  const std::vector<hal::OffAction>& off_;
  std::optional<RealTimeSettings> loop_;
  const std::atomic<std::int64_t>& lease_ends_ns_;
  std::atomic<std::uint64_t>& stops_;
  std::jthread thread_;  // last: it ends before what it uses
};

}  // namespace smaservo::daemon
