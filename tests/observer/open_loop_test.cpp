#include "observer/open_loop.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "tests/observer/simulated_wire.hpp"

namespace smaservo::open_loop_test {
namespace {

using OpenLoop = OpenLoopObserver<double>;

static_assert(StrainObserver<OpenLoopObserver<double>>);
static_assert(StrainObserver<OpenLoopObserver<float>>);

OpenLoop::Params tuned() {
  OpenLoop::Params p{plant_params(bench_wire())};
  p.model.kinetics.smallest_reversal_K = 0;
  return p;
}

/// Mean error over a run, share of the nominal stroke.
double mean_error(const Deviations& deviations, double stress_Pa) {
  const OpenLoop::Params p = tuned();
  LumpedWire wire(deviations, stress_Pa, 1);
  Profile profile(stress_Pa, 2);
  OpenLoop::State s = OpenLoop::start(p, wire.step(0), told_ambient_K);
  double sum = 0;
  for (int i = 0; i < 30000; ++i) {
    Measurement<double> m = wire.step(profile.power_W(i * sample_s));
    m.resistance_ohm = std::numeric_limits<double>::quiet_NaN();  // not looked at
    OpenLoop::advance(p, s, m, sample_s);
    sum += std::abs(OpenLoop::estimate(p, s).strain - wire.strain()) / 0.04;
  }
  return sum / 30000;
}

TEST(OpenLoop, IsThePlantWhereNothingDeviates) {
  Deviations none;
  none.stress_noise_Pa = 0;
  for (const double stress_Pa : {50e6, 200e6}) {
    EXPECT_LT(mean_error(none, stress_Pa), 1e-12);
  }
}

// Without the resistance, the error of 5 K in the air's temperature appears in the strain
// unnoticed.
TEST(OpenLoop, ErrsWithItsSurroundings) {
  Deviations warm;
  warm.ambient_K = 5;
  EXPECT_GT(mean_error(warm, 150e6), 0.01);
  EXPECT_LT(mean_error(warm, 150e6), 0.4);
}

TEST(OpenLoop, KeepsTheLastStress) {
  const OpenLoop::Params p = tuned();
  const Measurement<double> m{20, 0.01, 0.05, 150e6, true, true, true};
  OpenLoop::State s = OpenLoop::start(p, m, told_ambient_K);
  OpenLoop::State blind = s;
  for (int i = 0; i < 1000; ++i) {
    OpenLoop::advance(p, s, m, sample_s);
    Measurement<double> bad = m;
    bad.stress_Pa = std::numeric_limits<double>::quiet_NaN();
    bad.stress_valid = false;
    OpenLoop::advance(p, blind, bad, sample_s);
  }
  EXPECT_EQ(OpenLoop::estimate(p, blind).strain, OpenLoop::estimate(p, s).strain);
}

}  // namespace
}  // namespace smaservo::open_loop_test
