#include "host-sim/tune/relay/relay.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace smaservo::tune {
namespace {

constexpr int periods = 8;
constexpr int counted_from = 3;

/// The record of a test: the ticks at which the relay switches up and, for each tick, the distance
/// of the variable from the moving set-point and the relay's part of the power.
struct Record {
  std::vector<int> up;
  std::vector<double> away, relay_W;
};

Record run(const RelayTask& t, RelayPlant& plant) {
  Record r;
  const double begin = plant.now;
  double y = plant.now;
  std::vector<double> waiting(static_cast<std::size_t>(t.delay_ticks), 0.0);
  bool up = true;
  for (int tick = 0; static_cast<int>(r.up.size()) <= periods && tick < 4000; ++tick) {
    const double at_s = tick * t.period_s;
    r.away.push_back(y - begin - t.rises_1_s * at_s);
    const double away = t.direction * r.away.back();
    if (up ? t.hysteresis < away : away < -t.hysteresis) {
      up = !up;
      if (up) {
        r.up.push_back(tick);
      }
    }
    waiting.push_back(up ? t.amplitude_W : -t.amplitude_W);
    r.relay_W.push_back(waiting.front());
    y = plant.advance(t.base_W + t.base_rises_W_s * at_s + waiting.front());
    waiting.erase(waiting.begin());
  }
  return r;
}

/// Amplitude of the oscillation between two ticks that are whole periods apart; a drift is
/// subtracted.
double harmonic(const std::vector<double>& x, int first, int last, double rad_by_tick) {
  const auto at = [&](int i) { return x[static_cast<std::size_t>(i)]; };
  const double drift = (at(last) - at(first)) / (last - first);
  std::complex<double> sum = 0;
  for (int i = first; i < last; ++i) {
    sum += (at(i) - drift * (i - first)) * std::polar(1.0, -rad_by_tick * (i - first));
  }
  return 2 * std::abs(sum) / (last - first);
}

}  // namespace

Oscillation relay_test(const RelayTask& task, RelayPlant plant) {
  const Record r = run(task, plant);
  if (static_cast<int>(r.up.size()) <= periods) {
    return {false, 0, 0};
  }
  const int first = r.up[counted_from];
  const int last = r.up[periods];
  const double mean_ticks = static_cast<double>(last - first) / (periods - counted_from);
  bool steady = true;
  for (std::size_t i = counted_from; i < periods; ++i) {
    steady = steady && std::abs(r.up[i + 1] - r.up[i] - mean_ticks) <= 0.2 * mean_ticks;
  }
  const double rad_by_tick = 2 * std::numbers::pi / mean_ticks;
  return {
      steady, rad_by_tick / task.period_s,
      harmonic(r.away, first, last, rad_by_tick) / harmonic(r.relay_W, first, last, rad_by_tick)};
}

Oscillation expected_oscillation(const LinearLoop& loop, const RelayTask& task) {
  LinearLoop bare = loop;
  bare.delay_ticks = task.delay_ticks;
  bare.law_W = 1;
  bare.gains = {};
  bare.fed_forward_W_K = 0;
  bare.lag_s = 0;
  // L(jω) = -1/N(a) = -(sqrt(a² - ε²) + jε) π/(4h): the highest ω with the right imaginary part.
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
  return {true, low, std::abs(open_loop(bare, low))};
}

bool agrees(const RelayCheck& check) {
  const auto near = [](double a, double b) { return a < relay_factor * b && b < relay_factor * a; };
  return check.tested.steady && near(check.tested.rad_s, check.expected.rad_s) &&
         near(check.tested.gain, check.expected.gain);
}

}  // namespace smaservo::tune
