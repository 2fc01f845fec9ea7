#include "firmware/bench/progress.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <unistd.h>
#include <utility>

#include "model/files/message.hpp"

namespace smaservo::bench {
namespace {

constexpr std::int64_t first_after_ns = 500'000'000;
constexpr std::int64_t every_ns = 200'000'000;

std::int64_t now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

}  // namespace

Progress::Progress(std::string what, std::uint64_t total)
    : what_(std::move(what)),
      total_(total),
      terminal_(isatty(STDERR_FILENO) == 1),
      start_ns_(now_ns()),
      next_ns_(start_ns_ + first_after_ns) {}

Progress::~Progress() {
  if (printed_) {
    files::redraw("");
  }
}

void Progress::update(std::uint64_t done) {
  if ((++calls_ & 0xfffU) == 0) {
    step(done);
  }
}

void Progress::step(std::uint64_t done) {
  if (terminal_ && now_ns() >= next_ns_) {
    print(done);
  }
}

void Progress::print(std::uint64_t done) {
  const std::int64_t now = now_ns();
  const double seconds = static_cast<double>(now - start_ns_) * 1e-9;
  if (total_ > 0) {
    const double share = std::min(1.0, static_cast<double>(done) / static_cast<double>(total_));
    files::redraw(fmt::format("{}: {:3.0f} %, {:.0f} s left", what_, 100 * share,
                              share > 0 ? seconds / share - seconds : 0.0));
  } else {
    files::redraw(
        fmt::format("{}: {:.1f} MB, {:.0f} s", what_, static_cast<double>(done) * 1e-6, seconds));
  }
  printed_ = true;
  next_ns_ = now + every_ns;
}

}  // namespace smaservo::bench
