// The frequency response of a loop against the loop itself: the firmware's PID closed on an exact
// first-order plant, in time.

#include "host-sim/tune/linear/loop.hpp"

#include <cmath>
#include <deque>
#include <gtest/gtest.h>
#include <random>

#include "firmware/control/pid.hpp"

namespace smaservo::tune {
namespace {

/// How the closed loop's deviation grows by tick in the long run: above 1 it is unstable.
double growth(const LinearLoop& l, double gain) {
  const double a = std::exp(-l.loss_W_K * l.period_s / l.capacity_J_K);
  const double K_W = (1 - a) / l.loss_W_K;
  std::deque<double> waiting(static_cast<std::size_t>(l.delay_ticks), 0.0);
  Pid<double>::State pid = Pid<double>::start(l.gains, 0, 0);
  double T = 1, seen = 0, before = 1, logs = 0;
  constexpr int ticks = 12000;
  for (int i = 0; i < ticks; ++i) {
    const double y = l.by_kelvin * T;
    seen = l.lag_s > 0 ? seen + (y - seen) * l.period_s / (l.period_s + l.lag_s) : y;
    const double power_W = -l.law_W * seen +
                           Pid<double>::step(l.gains, {}, 1.0, pid, 0.0, seen, l.period_s) +
                           l.fed_forward_W_K * T;
    waiting.push_back(gain * power_W);
    T = a * T + K_W * waiting.front();
    waiting.pop_front();
    if (i % 1000 == 999) {
      // The state is scaled back, so that it neither vanishes nor overflows.
      double size = std::abs(T) + std::abs(seen) + std::abs(pid.integral_W) * K_W;
      for (const double power : waiting) {
        size += std::abs(power) * K_W;
      }
      logs = i < 6000 ? 0 : logs + std::log(size / before);
      before = 1;
      T /= size;
      seen /= size;
      pid.integral_W /= size;
      pid.filtered /= size;
      for (double& power : waiting) {
        power /= size;
      }
    }
  }
  return logs;
}

LinearLoop random_loop(std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto log = [&](double low, double high) {
    return low * std::pow(high / low, uniform(random));
  };
  LinearLoop l{1e-3,
               static_cast<int>(3 * uniform(random)),
               log(1e-4, 1e-1),
               0,
               log(0.01, 10),
               uniform(random) < 0.3 ? 0.023 : 0,
               0,
               0,
               {}};
  l.loss_W_K = l.capacity_J_K / log(0.05, 5);
  l.fed_forward_W_K = uniform(random) < 0.5 ? l.loss_W_K * log(0.5, 1.5) : 0;
  const double deadbeat = l.capacity_J_K / (l.by_kelvin * l.period_s);
  l.law_W = uniform(random) < 0.5 ? deadbeat * log(0.02, 0.3) : 0;
  l.gains = {deadbeat * log(0.02, 0.3), log(0.1, 30), 0, 0.005, 1, 0, 1, 1, 0};
  l.gains.derivative_s = uniform(random) < 0.3 ? log(1e-4, 3e-3) : 0;
  return l;
}

TEST(Loop, OscillatesAtItsGainMargin) {
  std::mt19937_64 random(5);
  int seen = 0;
  for (int i = 0; i < 40; ++i) {
    const LinearLoop l = random_loop(random);
    const Margins m = margins(l);
    if (!m.stable) {
      EXPECT_GT(growth(l, 1), 0) << i;
      continue;
    }
    ++seen;
    EXPECT_LT(growth(l, 1), 0) << i;
    EXPECT_LT(growth(l, 0.98 * m.gain), 0) << i;
    EXPECT_GT(growth(l, 1.02 * m.gain), 0) << i;
  }
  EXPECT_GT(seen, 20);
}

TEST(Loop, IsAnIntegratorWithOneAndAHalfTicksOfDelayFarBelowNyquist) {
  const double C = 0.01, law_W = 0.2;
  const LinearLoop l{1e-3, 1, C, 1e-9, 1, 0, 0, law_W, {}};
  const Margins m = margins(l);
  const double KL = law_W / C * 1.5e-3;
  EXPECT_NEAR(m.phase_rad, std::numbers::pi / 2 - KL, 1e-3);
  EXPECT_NEAR(m.crossover_rad_s, law_W / C, 1e-3 * m.crossover_rad_s);
}

}  // namespace
}  // namespace smaservo::tune
