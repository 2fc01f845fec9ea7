#include "host-sim/page/servos/traffic/live_round.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace smaservo::page {
namespace {

/// All signals, beginning with those that a page shows first.
constexpr std::array<std::size_t, signal_count> by_importance = [] {
  std::array<std::size_t, signal_count> order{
      signal_index("strain"),          signal_index("position_m"),
      signal_index("setpoint"),        signal_index("wire_temperature_K"),
      signal_index("drive_current_A"), signal_index("resistance_ohm"),
      signal_index("power_W"),         signal_index("stress_Pa"),
      signal_index("hot_spot_K"),      signal_index("resistance_model_ohm"),
      signal_index("limit_reasons"),   signal_index("reference"),
      signal_index("strain_sd"),       signal_index("wanted_power_W"),
      signal_index("martensite"),      signal_index("r_phase")};
  std::size_t n = 16;
  for (std::size_t i = 0; i < signal_count; ++i) {
    if (std::find(order.begin(), order.begin() + n, i) == order.begin() + n) {
      order.at(n++) = i;
    }
  }
  return order;
}();

/// Rate of the rounds for which the bus must have room: a little more than the promised rate.
constexpr double rounds_per_s = 55;
constexpr double min_in_each = 4;
/// Period of the rounds of live values: 80 Hz.
constexpr std::int64_t period_us = 12'500;
/// Promised period of the samples. A time between two samples of twice that or more counts as
/// missing samples.
constexpr std::int64_t promised_us = 20'000;

}  // namespace

PolledSignals polled_signals(double requests_per_s, const SignalSet* by_sync) {
  const double room = requests_per_s / rounds_per_s - 1;
  const auto first =
      static_cast<std::size_t>(std::clamp(room, min_in_each, static_cast<double>(signal_count)));
  PolledSignals polled;
  for (const std::size_t signal : by_importance) {
    if (by_sync != nullptr && (*by_sync)[signal]) {
      continue;
    }
    const bool in_each = by_sync == nullptr && polled.fast.size() < first;
    (in_each ? polled.fast : polled.slow).push_back(signal);
  }
  return polled;
}

void LiveRound::begin(PolledSignals signals, std::int64_t now_us) {
  due_us_ = std::max(due_us_ + period_us, now_us);
  signals_ = std::move(signals);
  fast_ = {};
  at_ = 0;
  running_ = !signals_.fast.empty() || !signals_.slow.empty();
}

std::size_t LiveRound::next() {
  const std::size_t at = at_++;
  asked_ = at < signals_.fast.size() ? signals_.fast[at]
                                     : signals_.slow[std::min(slow_at_, signals_.slow.size() - 1)];
  return asked_;
}

LiveRound::Completed LiveRound::take(std::optional<float> value, std::int64_t now_us) {
  Completed completed;
  if (value) {
    Sample& sample = at_ <= signals_.fast.size() ? fast_ : slow_;
    sample.has.set(asked_);
    sample.values[asked_] = *value;
    sample.time_us = now_us;
  }
  if (at_ == signals_.fast.size() && at_ != 0) {
    const std::int64_t since_us = now_us - last_us_;
    if (last_us_ != 0 && since_us >= 2 * promised_us) {
      gaps_ += static_cast<std::uint64_t>(since_us / promised_us - 1);
    }
    last_us_ = now_us;
    if (fast_.has.any()) {
      completed.fast = fast_;
    }
  }
  if (at_ < signals_.fast.size() + (signals_.slow.empty() ? 0 : 1)) {
    return completed;
  }
  running_ = false;
  if (++slow_at_ < signals_.slow.size()) {
    return completed;
  }
  slow_at_ = 0;
  if (slow_.has.any()) {
    completed.slow = slow_;
  }
  slow_ = {};
  return completed;
}

void LiveRound::stop() {
  running_ = false;
  last_us_ = 0;
}

std::optional<double> SampleRate::count(std::int64_t now_us) {
  ++count_;
  const std::int64_t span_us = now_us - since_us_;
  if (span_us < 1'000'000) {
    return std::nullopt;
  }
  since_us_ = now_us;
  return 1e6 * std::exchange(count_, 0) / static_cast<double>(span_us);
}

}  // namespace smaservo::page
