#include "host-sim/page/servos/traffic/live_round.hpp"

#include <algorithm>
#include <array>

namespace smaservo::page {
namespace {

/// What a page shows first.
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

/// A little more than the promised rate.
constexpr double rounds_per_s = 55;
constexpr double min_in_each = 4;

}  // namespace

LiveRound live_round(double requests_per_s, const SignalSet* by_sync) {
  const double room = requests_per_s / rounds_per_s - 1;
  const auto first =
      static_cast<std::size_t>(std::clamp(room, min_in_each, static_cast<double>(signal_count)));
  LiveRound round;
  for (const std::size_t signal : by_importance) {
    if (by_sync != nullptr && (*by_sync)[signal]) {
      continue;
    }
    const bool in_each = by_sync == nullptr && round.fast.size() < first;
    (in_each ? round.fast : round.slow).push_back(signal);
  }
  return round;
}

}  // namespace smaservo::page
