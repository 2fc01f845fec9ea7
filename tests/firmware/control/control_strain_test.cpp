// The strain loop of the controller: where it comes to rest.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <random>

#include "tests/firmware/device/closed_loop.hpp"

namespace smaservo::control_strain_test {
namespace {

constexpr double stroke = 0.04;

/// Strains of a wire in the last half of a second, in % of the stroke from the set-point.
struct Rest {
  double mean, ripple, overshoot;
};
Rest rest_at(ClosedLoop<>& loop, double setpoint, double seconds, double dt_s = 1e-3) {
  const double way = setpoint - loop.wire.strain();
  const double until_s = loop.time_s + seconds;
  double low = 1, high = -1, sum = 0, overshoot = 0;
  int n = 0;
  loop.run(
      seconds, Mode::strain, setpoint,
      [&](const auto&) {
        const double error = loop.wire.strain() - setpoint;
        overshoot = std::max(overshoot, way < 0 ? -error : error);
        if (until_s - 0.5 < loop.time_s) {
          low = std::min(low, error);
          high = std::max(high, error);
          sum += error;
          ++n;
        }
      },
      dt_s);
  return {100 * sum / n / stroke, 100 * (high - low) / stroke, 100 * overshoot / stroke};
}

struct Case {
  Settings<double> settings = test_settings();
  double stress_Pa = 150e6;
  bool ideal_sensor = true;
  double dt_s = 1e-3;
};
/// The worst of twenty random steps.
Rest worst_rest(const Case& c) {
  ClosedLoop<> loop(c.settings, c.stress_Pa);
  loop.ideal_sensor = c.ideal_sensor;
  const double longest = loop.wire.strain();
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> contraction(0.003, c.stress_Pa < 80e6 ? 0.026 : 0.033);
  Rest worst{};
  for (int i = 0; i < 20; ++i) {
    const Rest rest = rest_at(loop, longest - contraction(random), 1.7, c.dt_s);
    worst = {std::max(worst.mean, std::abs(rest.mean)), std::max(worst.ripple, rest.ripple),
             std::max(worst.overshoot, rest.overshoot)};
  }
  std::printf("%.0f MPa, %.1f ms%s: steady %.2f, ripple %.3f, overshoot %.2f %% of the stroke\n",
              c.stress_Pa / 1e6, c.dt_s * 1e3, c.ideal_sensor ? ", ideal sensor" : "", worst.mean,
              worst.ripple, worst.overshoot);
  return worst;
}

TEST(Controller, RestsInItsDeadBand) {
  const double band = 100 * test_settings().strain.dead_band / stroke;
  for (const double stress_Pa : {50e6, 100e6, 150e6, 300e6}) {
    const Rest rest = worst_rest({.stress_Pa = stress_Pa});
    EXPECT_LT(rest.mean, band);
    EXPECT_LT(rest.overshoot, band);
    EXPECT_LT(rest.ripple, 0.05);
  }
}

TEST(Controller, RestsInASlowLoopAndInAFastOne) {
  const double band = 100 * test_settings().strain.dead_band / stroke;
  for (const double dt_s : {0.5e-3, 2e-3, 5e-3}) {
    const Rest rest = worst_rest({.dt_s = dt_s});
    EXPECT_LT(rest.mean, band);
    EXPECT_LT(rest.overshoot, dt_s < 3e-3 ? band : 1.5);
    EXPECT_LT(rest.ripple, 0.05);
  }
}

TEST(Controller, AnIntegralIsNotWoundUpByCooling) {
  // In this case the loop asks for no power at all for hundreds of milliseconds, again and again.
  const Rest rest = worst_rest({.settings = settings_with_pid()});
  EXPECT_LT(rest.mean, 0.25);
  EXPECT_LT(rest.overshoot, 0.3);
}

/// With the observer instead of an ideal sensor, the remaining error is that of the estimate, which
/// has tests of its own.
TEST(Controller, RestsWhereTheObserverSeesIt) {
  struct Bound {
    double stress_Pa, steady;
  };
  for (const Bound& bound :
       {Bound{50e6, 1.6}, Bound{100e6, 1.1}, Bound{150e6, 0.5}, Bound{300e6, 0.35}}) {
    const Rest rest = worst_rest({.stress_Pa = bound.stress_Pa, .ideal_sensor = false});
    EXPECT_LT(rest.mean, bound.steady);
    EXPECT_LT(rest.ripple, 0.5);
  }
}

}  // namespace
}  // namespace smaservo::control_strain_test
