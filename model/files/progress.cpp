#include "model/files/progress.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <exception>
#include <fmt/format.h>
#include <unistd.h>
#include <utility>

#include "model/files/message.hpp"

namespace smaservo::files {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// The times of a terminal, and of any other output.
struct Pace {
  milliseconds first, then;
};
constexpr Pace on_a_terminal{milliseconds(500), milliseconds(1000)};
constexpr Pace elsewhere{milliseconds(10'000), milliseconds(10'000)};

}  // namespace

std::chrono::milliseconds pause_in_a_log(std::chrono::milliseconds elapsed) {
  return std::max(elsewhere.then, elapsed / 30);
}

std::string duration_text(double seconds) {
  const long whole = std::lround(std::min(seconds, 1e9));
  if (whole < 100) {
    return fmt::format("{} s", whole);
  }
  const long minutes = std::lround(static_cast<double>(whole) / 60);
  return minutes < 100 ? fmt::format("{} min", minutes)
                       : fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
}

std::string Forecast::text(std::string_view what, double share, double elapsed_s) {
  if (!(0 < share)) {
    return fmt::format("{}: {} so far", what, duration_text(elapsed_s));
  }
  if (share != share_) {
    share_ = share;
    whole_s_ = elapsed_s / std::min(1.0, share);
  }
  const double left_s = whole_s_ - elapsed_s;
  return fmt::format(
      "{}: {:.0f} %, {}", what, std::floor(100 * std::min(1.0, share)),
      left_s < 0 ? "longer than expected" : fmt::format("{} left", duration_text(left_s)));
}

Progress::Progress(std::string what, std::uint64_t total)
    : what_(std::move(what)),
      total_(total),
      thread_([this](const std::stop_token& stop) { show(stop); }) {}

Progress::~Progress() {
  thread_.request_stop();
  thread_.join();
}

void Progress::name(std::string what) {
  const std::scoped_lock lock(mutex_);
  what_ = std::move(what);
}

std::string Progress::text(Forecast& forecast, double elapsed_s) const {
  const auto done = static_cast<double>(done_.load(std::memory_order_relaxed));
  return total_ == 0
             ? fmt::format("{}: {:.1f} MB, {} so far", what_, 1e-6 * done, duration_text(elapsed_s))
             : forecast.text(what_, done / static_cast<double>(total_), elapsed_s);
}

void Progress::show(const std::stop_token& stop) noexcept {
  // Signals are for the other threads. Above all, nobody's work ends because nobody reads how far
  // it is (SIGPIPE).
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
  const bool terminal = isatty(STDERR_FILENO) == 1;
  const Pace pace = terminal ? on_a_terminal : elsewhere;
  const auto start = Clock::now();
  auto due = start + pace.first;
  bool shown = false;
  Forecast forecast;
  try {
    std::unique_lock lock(mutex_);
    while (!wakes_.wait_until(lock, stop, due, [&] { return stop.stop_requested(); })) {
      const auto now = Clock::now();
      const std::string line = text(forecast, std::chrono::duration<double>(now - start).count());
      if (terminal) {
        redraw(line);
      } else {
        complain("host-sim", line);
      }
      shown = true;
      // A program that stood still makes up for nothing.
      due = std::max(
          due + (terminal ? pace.then
                          : pause_in_a_log(std::chrono::duration_cast<milliseconds>(now - start))),
          now);
    }
    if (shown && terminal) {
      redraw("");
    }
  } catch (const std::exception& error) {
    // The work goes on without.
    complain("host-sim", error.what());
  }
}

}  // namespace smaservo::files
