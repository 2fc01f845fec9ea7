#include "host-sim/tune/relay.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace smaservo {
namespace {

constexpr int periods = 8;
constexpr int counted_from = 3;

/// Where a relay switches up: the tick, and the share of it that lies before.
struct Switches {
  std::vector<int> up;
  std::vector<double> away;  ///< from the moving set-point, each tick
};

Switches run(const RelayTask& t, RelayPlant& plant) {
  Switches s;
  const double begin = plant.now;
  double y = plant.now;
  std::vector<double> waiting(static_cast<std::size_t>(t.delay_ticks), t.base_W);
  bool up = true;
  for (int tick = 0; static_cast<int>(s.up.size()) <= periods && tick < 4000; ++tick) {
    const double away = t.direction * (y - begin - t.rises_1_s * tick * t.period_s);
    s.away.push_back(away);
    if (up ? t.hysteresis < away : away < -t.hysteresis) {
      up = !up;
      if (up) {
        s.up.push_back(tick);
      }
    }
    waiting.push_back(t.base_W + (up ? t.amplitude_W : -t.amplitude_W));
    y = plant.advance(waiting.front());
    waiting.erase(waiting.begin());
  }
  return s;
}

}  // namespace

Oscillation relay_test(const RelayTask& task, RelayPlant plant) {
  const Switches s = run(task, plant);
  if (static_cast<int>(s.up.size()) <= periods) {
    return {false, 0, 0, 0};
  }
  const int first = s.up[counted_from];
  const int last = s.up[periods];
  const double mean_ticks = static_cast<double>(last - first) / (periods - counted_from);
  bool steady = true;
  for (std::size_t i = counted_from; i < periods; ++i) {
    steady = steady && std::abs(s.up[i + 1] - s.up[i] - mean_ticks) <= 0.2 * mean_ticks;
  }
  const auto [low, high] = std::minmax_element(s.away.begin() + first, s.away.begin() + last);
  const double amplitude = 0.5 * (*high - *low);
  return {steady, 2 * std::numbers::pi / (mean_ticks * task.period_s), amplitude,
          std::numbers::pi * amplitude / (4 * task.amplitude_W)};
}

Oscillation expected_oscillation(const LinearLoop& loop, const RelayTask& task) {
  LinearLoop bare = loop;
  bare.delay_ticks = task.delay_ticks;
  bare.law_W = 1;
  bare.gains = {};
  bare.fed_forward_W_K = 0;
  bare.lag_s = 0;
  // L(jω) = -1/N(a) = -(sqrt(a² - ε²) + jε) π/(4h): the highest ω at which the imaginary part fits.
  const double asked = -std::numbers::pi * task.hysteresis / (4 * task.amplitude_W);
  const double nyquist = std::numbers::pi / task.period_s;
  double high = nyquist;
  double low = nyquist;
  while (asked < open_loop(bare, low).imag() && 1e-6 * nyquist < low) {
    high = low;
    low *= 0.95;
  }
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (asked < open_loop(bare, middle).imag() ? high : low) = middle;
  }
  const double gain = std::abs(open_loop(bare, low));
  return {true, low, 4 * task.amplitude_W * gain / std::numbers::pi, gain};
}

bool agrees(const RelayCheck& check) {
  const auto near = [](double a, double b) { return a < relay_factor * b && b < relay_factor * a; };
  return check.tested.steady && near(check.tested.rad_s, check.expected.rad_s) &&
         near(check.tested.gain, check.expected.gain);
}

}  // namespace smaservo
