#pragma once
// Switches the heat off when the program crashes, before the program ends.

#include <array>
#include <atomic>
#include <csignal>
#include <cstddef>
#include <vector>

#include "firmware/daemon/process/last_run.hpp"
#include "hal/linux/system/off_action.hpp"

namespace smaservo::daemon {

/// Signals that are raised by an error in the program, and SIGQUIT, which requests a core dump.
inline constexpr std::array crash_signals{SIGSEGV, SIGBUS, SIGFPE,  SIGILL,
                                          SIGABRT, SIGSYS, SIGTRAP, SIGQUIT};

/// Stack for a crash handler, needed if the thread's own stack caused the crash.
class SignalStack {
 public:
  SignalStack() : memory_(size) {}
  /// From now on the calling thread's handlers run on this stack; it must outlive the thread.
  void use();

 private:
  /// More than the registers of any processor need.
  static constexpr std::size_t size = std::size_t{64} * 1024;
  std::vector<std::byte> memory_;
};

/// While a CrashGuard lives, one of crash_signals switches the outputs off, leaves a mark and then
/// ends the program as it would without the guard. Only one guard may live at a time. The handler
/// makes system calls only.
class CrashGuard {
 public:
  /// `mark` null: no mark is left. `heated` and the board must outlive the guard. The calling
  /// thread gets a SignalStack.
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
