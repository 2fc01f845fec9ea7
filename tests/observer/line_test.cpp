#include "observer/line.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "tests/observer/simulated_wire.hpp"

namespace smaservo::line_test {
namespace {

using Line = LineObserver<double>;

static_assert(StrainObserver<LineObserver<double>>);
static_assert(StrainObserver<LineObserver<float>>);

Line::Params tuned() {
  return {plant_params(bench_wire())};
}

double strain_at(double ohm, double stress_Pa) {
  const Measurement<double> m{ohm, 0.01, 0, stress_Pa, true, true, true};
  return Line::estimate(tuned(), Line::start(tuned(), m, told_ambient_K)).strain;
}

TEST(Line, EndsAreMartensiteAndAustenite) {
  const Line::Params p = tuned();
  for (const double stress_Pa : {50e6, 150e6, 300e6}) {
    const double cold = strain_at(1000, stress_Pa);
    const double hot = strain_at(0.1, stress_Pa);
    EXPECT_NEAR(cold, strain<double>(p.model.material, {1, 0}, stress_Pa), 1e-12);
    EXPECT_NEAR(hot, strain<double>(p.model.material, {0, 0}, stress_Pa), 1e-12);
    EXPECT_GT(cold - hot, 0.04);
  }
}

TEST(Line, IsStraightInBetween) {
  const double low = strain_at(20.5, 150e6);
  const double middle = strain_at(21.5, 150e6);
  const double high = strain_at(22.5, 150e6);
  EXPECT_GT(middle, low + 0.005);
  EXPECT_NEAR(high - middle, middle - low, 1e-12);
}

TEST(Line, KeepsItsLastWordWithoutAReading) {
  const Line::Params p = tuned();
  Measurement<double> m{21.5, 0.01, 0, 150e6, true, true, true};
  Line::State s = Line::start(p, m, told_ambient_K);
  const double before = Line::estimate(p, s).strain;
  m.resistance_ohm = std::numeric_limits<double>::quiet_NaN();
  m.stress_Pa = std::numeric_limits<double>::quiet_NaN();
  m.resistance_valid = m.stress_valid = false;
  Line::advance(p, s, m, sample_s);
  EXPECT_EQ(Line::estimate(p, s).strain, before);
}

// Why it is a reference and not the observer: it knows neither hysteresis nor R-phase.
TEST(Line, ErrsByTheHysteresis) {
  const Line::Params p = tuned();
  double worst = 0;
  LumpedWire wire({}, 100e6, 1);
  Profile profile(100e6, 2);
  Line::State s = Line::start(p, wire.step(0.01), told_ambient_K);
  for (int i = 0; i < 12000; ++i) {
    Line::advance(p, s, wire.step(profile.power_W(i * sample_s)), sample_s);
    worst = std::max(worst, std::abs(Line::estimate(p, s).strain - wire.strain()) / 0.04);
  }
  EXPECT_GT(worst, 0.08);
  EXPECT_LT(worst, 0.6);
}

}  // namespace
}  // namespace smaservo::line_test
