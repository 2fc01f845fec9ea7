#include "firmware/daemon/process/crash.hpp"

#include <unistd.h>
#include <utility>

namespace smaservo::daemon {
namespace {

// Global, because a signal handler has no argument but its signal.
// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
std::atomic<const CrashGuard*> installed{nullptr};

void set_handlers(void (*handler)(int)) {
  struct sigaction action{};
  action.sa_handler = handler;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_ONSTACK;
  for (const int signal : crash_signals) {
    sigaction(signal, &action, nullptr);
  }
}

// AddressSanitizer gives each thread a signal stack, and frees whichever one is installed when the
// thread ends.
#ifdef __SANITIZE_ADDRESS__
constexpr bool has_own_stack = true;
#elif defined(__has_feature)
constexpr bool has_own_stack = __has_feature(address_sanitizer);
#else
constexpr bool has_own_stack = false;
#endif

}  // namespace

void SignalStack::use() {
  if (has_own_stack) {
    return;
  }
  const stack_t stack{.ss_sp = memory_.data(), .ss_flags = 0, .ss_size = memory_.size()};
  sigaltstack(&stack, nullptr);
}

CrashGuard::CrashGuard(std::vector<hal::OffAction> off, const RunMark* mark,
                       const std::atomic<bool>& heated)
    : off_(std::move(off)), mark_(mark == nullptr ? -1 : mark->descriptor()), heated_(heated) {
  for (std::size_t i = 0; mark != nullptr && i < crash_signals.size(); ++i) {
    blocks_.at(i) = {mark->crash_block(crash_signals.at(i), false),
                     mark->crash_block(crash_signals.at(i), true)};
  }
  static SignalStack stack;
  stack.use();
  installed.store(this);
  set_handlers(handle);
}

CrashGuard::~CrashGuard() {
  set_handlers(SIG_DFL);
  installed.store(nullptr);
}

void CrashGuard::handle(int signal) {
  const CrashGuard* const self = installed.load();
  if (self != nullptr) {
    hal::switch_off(self->off_);
    for (std::size_t i = 0; i < crash_signals.size(); ++i) {
      if (crash_signals[i] != signal || self->mark_ < 0) {
        continue;
      }
      const RunMark::Block& block =
          self->heated_.load() ? self->blocks_[i].heated : self->blocks_[i].off;
      if (pwrite(self->mark_, block.data(), block.size(), 0) > 0) {
        fdatasync(self->mark_);
      }
    }
  }
  // The default handler is in force again (SA_RESETHAND); it ends the program as soon as this
  // handler returns.
  raise(signal);
}

}  // namespace smaservo::daemon
