#include "model/files/progress.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
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

std::string duration_text(double seconds) {
  const auto whole = static_cast<long>(std::lround(std::min(seconds, 1e9)));
  if (whole < 100) {
    return fmt::format("{} s", whole);
  }
  const long minutes = std::lround(static_cast<double>(whole) / 60);
  return minutes < 100 ? fmt::format("{} min", minutes)
                       : fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
}

std::string Forecast::text(std::string_view what, double share, double elapsed_s) {
  if (!(0 < share)) {
    return fmt::format("{}: {}", what, duration_text(elapsed_s));
  }
  if (share != share_) {
    share_ = share;
    whole_s_ = elapsed_s / std::min(1.0, share);
  }
  return fmt::format("{}: {:.0f} %, {} left", what, std::floor(100 * std::min(1.0, share)),
                     duration_text(std::max(0.0, whole_s_ - elapsed_s)));
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

void Progress::show(const std::stop_token& stop) {
  const bool terminal = isatty(STDERR_FILENO) == 1;
  const Pace pace = terminal ? on_a_terminal : elsewhere;
  const auto start = Clock::now();
  auto due = start + pace.first;
  bool shown = false;
  Forecast forecast;
  std::unique_lock lock(mutex_);
  while (!wakes_.wait_until(lock, stop, due, [&] { return stop.stop_requested(); })) {
    const double elapsed_s = std::chrono::duration<double>(Clock::now() - start).count();
    const auto done = static_cast<double>(done_.load(std::memory_order_relaxed));
    const std::string text =
        total_ == 0 ? fmt::format("{}: {:.1f} MB, {}", what_, 1e-6 * done, duration_text(elapsed_s))
                    : forecast.text(what_, done / static_cast<double>(total_), elapsed_s);
    if (terminal) {
      files::redraw(text);
    } else {
      files::complain("host-sim", text);
    }
    shown = true;
    due += pace.then;
  }
  if (shown && terminal) {
    files::redraw("");
  }
}

}  // namespace smaservo::files
