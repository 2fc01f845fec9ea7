#include "host-sim/end_by_signal.hpp"

namespace smaservo {
namespace {

constexpr std::array ending_signals{SIGINT, SIGTERM, SIGHUP};

volatile std::sig_atomic_t& signal_that_came() {
  static volatile std::sig_atomic_t signal = 0;
  return signal;
}

}  // namespace

EndBySignal::EndBySignal() {
  signal_that_came() = 0;
  struct sigaction action{};
  action.sa_handler = [](int signal) { signal_that_came() = signal; };
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  for (std::size_t i = 0; i < ending_signals.size(); ++i) {
    sigaction(ending_signals[i], nullptr, &before_[i]);
    // One that is ignored, as by nohup, stays so.
    if (before_[i].sa_handler != SIG_IGN) {
      sigaction(ending_signals[i], &action, nullptr);
    }
  }
}

EndBySignal::~EndBySignal() {
  for (std::size_t i = 0; i < ending_signals.size(); ++i) {
    sigaction(ending_signals[i], &before_[i], nullptr);
  }
  if (signal_that_came() != 0) {
    raise(signal_that_came());
  }
}

bool EndBySignal::came() {
  return signal_that_came() != 0;
}

}  // namespace smaservo
