#pragma once
// What each signal does to a run. None ends it before the outputs are off, but SIGKILL, which only
// the hardware's one-shot guards against, as it does against SIGSTOP.
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

/// Puts that into force, for the calling thread and those that it starts. The crash signals stay as
/// they are, but are no longer blocked where whoever has started the program did so.
void take_signals();

/// Waits for SIGHUP or one of ending_signals; 0: none came in this time, less than a second.
int wait_for_signal(std::int64_t time_ns);

}  // namespace smaservo::daemon
