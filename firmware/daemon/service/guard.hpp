#pragma once
// Enforces the lease in software: if the loop hangs, even in a device's driver, its outputs are
// still switched off. If the whole program stops, only the hardware's one-shot helps.

#include <atomic>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "firmware/daemon/process/realtime.hpp"
#include "hal/linux/system/off_action.hpp"

namespace smaservo::daemon {

/// Decides when the outputs have to be switched off.
class LeaseWatch {
 public:
  /// Whether the lease that ends at `ends_ns` has run out; reported once for each lease. 0: there
  /// is none.
  bool has_run_out(std::int64_t ends_ns, std::int64_t now_ns) {
    if (ends_ns == 0 || ends_ns == revoked_ns_ || ends_ns >= now_ns) {
      return false;
    }
    revoked_ns_ = ends_ns;
    return true;
  }

 private:
  std::int64_t revoked_ns_ = 0;
};

/// During its life a thread of its own checks the lease every 2 ms.
class LeaseGuard {
 public:
  /// `loop`: the loop's real-time settings, if any; the guard's priority is one higher. The
  /// outputs, the lease (LoopLinks::lease_ends_ns) and `stops`, which counts how often the guard
  /// had to switch off, must outlive the guard.
  LeaseGuard(const std::vector<hal::OffAction>& off, const std::optional<RealTimeSettings>& loop,
             const std::atomic<std::int64_t>& lease_ends_ns, std::atomic<std::uint64_t>& stops);

 private:
  void run(const std::stop_token& stop) const;

  const std::vector<hal::OffAction>& off_;
  std::optional<RealTimeSettings> loop_;
  const std::atomic<std::int64_t>& lease_ends_ns_;
  std::atomic<std::uint64_t>& stops_;
  std::jthread thread_;  // declared last, so that it ends before the members that it uses
};

}  // namespace smaservo::daemon
