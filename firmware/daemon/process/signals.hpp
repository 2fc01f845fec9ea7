#pragma once
// The effect of each signal on a run. No signal ends it before the outputs are off, except SIGKILL;
// against SIGKILL and SIGSTOP only the hardware's one-shot guards.
//
//   SIGHUP                      reads the settings file anew
//   ending_signals              end the run: the loop switches off
//   crash_signals (crash.hpp)   their handler switches off
//   all others                  are ignored: a dead pipe or a full quota is an error of the write

#include <array>
#include <csignal>
#include <cstdint>

namespace smaservo::daemon {

/// SIGXCPU comes some time before a limit of processor time ends the process by SIGKILL.
inline constexpr std::array ending_signals{SIGTERM, SIGINT, SIGPWR, SIGXCPU};

/// Puts these effects into force, for the calling thread and those that it starts. The handling of
/// crash signals is not changed, but they are unblocked in case the parent process has blocked
/// them.
void take_signals();

/// Waits for SIGHUP or one of ending_signals for less than a second; 0 if none came in this time.
int wait_for_signal(std::int64_t time_ns);

}  // namespace smaservo::daemon
