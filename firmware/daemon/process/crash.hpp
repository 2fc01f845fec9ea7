#pragma once
// Switches the heat off when the program crashes, before it ends.

#include <array>
#include <atomic>
#include <csignal>
#include <vector>

#include "firmware/daemon/process/last_run.hpp"
#include "hal/linux/system/off_action.hpp"

namespace smaservo::daemon {

/// Signals that a mistake in the program raises.
inline constexpr std::array crash_signals{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGSYS};

/// While a CrashGuard lives, such a signal switches the outputs off, leaves a mark and then ends
/// the program as it would without the guard. Only one may live at a time. The handler makes system
/// calls only.
class CrashGuard {
 public:
  /// `mark` null: no mark is left. `heated` and the board must outlive the guard.
  CrashGuard(std::vector<hal::OffAction> off, const RunMark* mark, const std::atomic<bool>& heated);
  ~CrashGuard();
  CrashGuard(const CrashGuard&) = delete;
  CrashGuard& operator=(const CrashGuard&) = delete;

 private:
  static void handle(int signal);

  struct Blocks {
    RunMark::Block off, heated;
  };
  std::vector<hal::OffAction> off_;
  int mark_;
  const std::atomic<bool>& heated_;
  std::array<Blocks, crash_signals.size()> blocks_{};
};

}  // namespace smaservo::daemon
