#include "firmware/daemon/process/signals.hpp"

#include <algorithm>
#include <ctime>
#include <sys/syscall.h>
#include <unistd.h>

#include "firmware/daemon/process/crash.hpp"

namespace smaservo::daemon {
namespace {

constexpr int last_signal = 64;

sigset_t set_of(const auto& signals) {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : signals) {
    sigaddset(&set, signal);
  }
  return set;
}

sigset_t waited_for() {
  sigset_t set = set_of(ending_signals);
  sigaddset(&set, SIGHUP);
  return set;
}

/// Ignores a signal by the system call, because sigaction() refuses the two signals that glibc
/// keeps for itself (32 and 33). glibc installs its own handlers when it needs them; until then
/// these signals would end the process.
void ignore(int signal) {
  struct {
    void (*handler)(int);
    unsigned long rest[4];  ///< flags, restorer, mask
  } action{SIG_IGN, {}};
  constexpr std::size_t mask_size = 8;
  syscall(SYS_rt_sigaction, signal, &action, nullptr, mask_size);
}

}  // namespace

void take_signals() {
  const sigset_t waited = waited_for();
  const sigset_t crashes = set_of(crash_signals);
  pthread_sigmask(SIG_BLOCK, &waited, nullptr);
  pthread_sigmask(SIG_UNBLOCK, &crashes, nullptr);
  constexpr std::array harmless{SIGKILL, SIGSTOP, SIGCHLD, SIGCONT, SIGURG, SIGWINCH};
  for (int signal = 1; signal <= last_signal; ++signal) {
    const auto is_in = [&](const auto& list) {
      return std::ranges::find(list, signal) != list.end();
    };
    if (!is_in(harmless) && !is_in(crash_signals) && !is_in(ending_signals) && signal != SIGHUP) {
      ignore(signal);
    }
  }
}

int wait_for_signal(std::int64_t time_ns) {
  const sigset_t set = waited_for();
  const timespec time{0, static_cast<long>(time_ns)};
  const int signal = sigtimedwait(&set, nullptr, &time);
  return signal > 0 ? signal : 0;
}

}  // namespace smaservo::daemon
