#include "firmware/daemon/service/guard.hpp"

#include <algorithm>

#include "hal/linux/system/clock.hpp"

namespace smaservo::daemon {
namespace {

constexpr std::int64_t guard_every_ns = 2'000'000;

}  // namespace

LeaseGuard::LeaseGuard(const std::vector<hal::OffAction>& off,
                       const std::optional<RealTimeSettings>& loop,
                       const std::atomic<std::int64_t>& lease_ends_ns,
                       std::atomic<std::uint64_t>& stops)
    : off_(off),
      loop_(loop),
      lease_ends_ns_(lease_ends_ns),
      stops_(stops),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

void LeaseGuard::run(const std::stop_token& stop) const {
  name_thread("guard");
  if (loop_) {
    make_real_time({std::min(loop_->priority + 1, 99), loop_->processor});
  }
  LeaseWatch watch;
  std::int64_t next_ns = hal::monotonic_ns();
  while (!stop.stop_requested()) {
    next_ns = std::max(next_ns + guard_every_ns, hal::monotonic_ns());
    hal::MonotonicClock::sleep_until(next_ns);
    // The clock is read first: a lease that the loop renews between the two readings must not look
    // like one that has run out. One that runs out in between is found at the next reading.
    const std::int64_t now_ns = hal::monotonic_ns();
    if (watch.has_run_out(lease_ends_ns_.load(), now_ns)) {
      hal::switch_off(off_);
      stops_.fetch_add(1);
    }
  }
}

}  // namespace smaservo::daemon
