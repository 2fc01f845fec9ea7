#include "observer/papers/strain_resistance.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace smaservo::strain_resistance_test {
namespace {

using Observer = papers::StrainResistance<double>;
static_assert(StrainObserver<papers::StrainResistance<double>>);
static_assert(StrainObserver<papers::StrainResistance<float>>);

constexpr double never = 1e9;  // seconds: the low-pass has settled

/// Two lines 0.06 apart in resistance, whose slopes and offsets depend on the stress.
Observer::Params params() {
  return {
      20, 15e6, 200e6, {{{0.25, 0.03}}, {{-0.22, 0.01}}}, {{{0.27, 0.01}}, {{-0.245, 0.002}}}, 0.05,
      60, 1e-4, 0.0004};
}

Measurement<double> reading(double resistance, double stress_Pa = 100e6) {
  return {resistance * params().martensite_ohm, 0.001, 0, stress_Pa, true, true, true};
}

double heating_line(double resistance, double stress_Pa) {
  return Observer::line(params().heating, params(), stress_Pa).strain(resistance);
}
double cooling_line(double resistance, double stress_Pa) {
  return Observer::line(params().cooling, params(), stress_Pa).strain(resistance);
}
double strain(const Observer::State& s) {
  return Observer::estimate(params(), s).strain;
}

void go(Observer::State& s, double to, int steps, double stress_Pa = 100e6) {
  const double from = s.reached;
  for (int i = 1; i <= steps; ++i) {
    Observer::advance(params(), s, reading(from + (to - from) * i / steps, stress_Pa), never);
  }
}

/// A wire that has just come down the heating line.
Observer::State heated() {
  Observer::State s = Observer::start(params(), reading(1.2), 298);
  go(s, 0.9, 300);
  return s;
}

TEST(StrainResistance, FullMotionsFollowTheLines) {
  for (const double stress_Pa : {20e6, 100e6, 180e6}) {
    Observer::State s = Observer::start(params(), reading(1.3, stress_Pa), 298);
    go(s, 0.9, 300, stress_Pa);
    EXPECT_NEAR(strain(s), heating_line(0.9, stress_Pa), 1e-6);
    go(s, 1.3, 300, stress_Pa);
    EXPECT_NEAR(strain(s), cooling_line(1.3, stress_Pa), 1e-6);
  }
}

TEST(StrainResistance, OneBigStepEqualsManySmallOnes) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 500; ++i) {
    Observer::State small = heated();
    std::uniform_real_distribution<double> uniform(0.85, 1.05);
    for (int turn = 0; turn < 4; ++turn) {
      go(small, uniform(random), 1);
    }
    Observer::State big = small;
    const double to = uniform(random);
    go(small, to, 37);
    go(big, to, 1);
    EXPECT_NEAR(strain(small), strain(big), 1e-12);
  }
}

// The paper's own recursion, eq. 26 to 28, with steps so small that its error vanishes.
TEST(StrainResistance, TransitionsAreThePapersRecursion) {
  const Observer::Params p = params();
  Observer::State s = heated();
  double epsilon = strain(s);
  double lambda = 0.9;
  const auto cooling = Observer::line(p.cooling, p, 100e6);
  const auto heating = Observer::line(p.heating, p, 100e6);
  constexpr int steps = 200000;
  // The last leg begins beyond the line: 5 mm per metre of elongation too many.
  for (const double to : {0.96, 0.93, 0.90}) {
    if (to == 0.90) {
      epsilon = s.low = s.high = heating.slope * lambda + heating.offset + 0.005;
    }
    const double step = (to - lambda) / steps;
    for (int i = 0; i < steps; ++i) {
      const double z = step > 0 ? (epsilon - cooling.offset) / cooling.slope - lambda
                                : lambda - (epsilon - heating.offset) / heating.slope;
      const double slope = step > 0 ? cooling.slope : heating.slope;
      epsilon += step * ((slope - p.initial_slope) * std::exp(-p.decay * z) + p.initial_slope);
      lambda += step;
    }
    const double before = strain(s);
    go(s, to, 10);
    EXPECT_NEAR(strain(s), epsilon, 1e-6);
    EXPECT_GT(std::abs(strain(s) - before), 1e-3);
  }
}

// 002 section 3.3: minor loops start flat and approach the heating or cooling path.
TEST(StrainResistance, MinorLoopsStayBetweenTheLines) {
  std::mt19937_64 random(3);
  Observer::State s = heated();
  for (int i = 0; i < 5000; ++i) {
    go(s, std::uniform_real_distribution<double>(0.85, 1.0)(random), 5);
    EXPECT_LE(strain(s), heating_line(s.reached, 100e6) + 1e-12);
    EXPECT_GE(strain(s), cooling_line(s.reached, 100e6) - 1e-12);
  }
}

// A bias spring does this all the time: no strain jumps when the lines move, and the way back to
// them is followed from either side.
TEST(StrainResistance, FollowsLinesThatTheStressMoves) {
  const Observer::Params p = params();
  for (const double stress_Pa : {15e6, 60e6, 140e6, 200e6}) {
    Observer::State s = heated();
    go(s, 0.96, 300);
    const double before = strain(s);
    go(s, 0.96 + 1e-6, 1, stress_Pa);
    EXPECT_NEAR(strain(s), before, 1e-5);
    double apart = std::abs(cooling_line(s.reached, stress_Pa) - strain(s));
    for (int i = 1; i < 10; ++i) {
      go(s, 0.96 + 0.02 * i, 5, stress_Pa);
      const double now = std::abs(cooling_line(s.reached, stress_Pa) - strain(s));
      EXPECT_LT(now, apart + 1e-12);
      apart = now;
    }
    EXPECT_LT(apart, p.strain_sd);
  }
}

TEST(StrainResistance, StartsSearchingAndFindsItselfAfterOneMotion) {
  const Observer::Params p = params();
  Observer::State s = Observer::start(p, reading(0.9), 298);
  EXPECT_EQ(Observer::estimate(p, s).health, Health::searching);
  EXPECT_GT(Observer::estimate(p, s).strain_sd, 10 * p.strain_sd);
  const double gap = s.high - s.low;
  EXPECT_NEAR(gap, heating_line(0.9, 100e6) - cooling_line(0.9, 100e6), 1e-12);
  go(s, 1.1, 100);
  EXPECT_EQ(Observer::estimate(p, s).health, Health::good);
  EXPECT_NEAR(Observer::estimate(p, s).strain_sd, p.strain_sd, 0.1 * p.strain_sd);
}

TEST(StrainResistance, NoiseBelowTheSmallestReversalDoesNotWalk) {
  Observer::State s = heated();
  go(s, 0.95, 100);
  const double before = strain(s);
  std::mt19937_64 random(5);
  for (int i = 0; i < 10000; ++i) {
    const double noise = std::uniform_real_distribution<double>(-0.4e-4, 0.4e-4)(random);
    Observer::advance(params(), s, reading(0.95 + noise), never);
  }
  EXPECT_NEAR(strain(s), before, 2e-5);
}

TEST(StrainResistance, StressBeyondTheIdentifiedRangeIsClampedAndDoubted) {
  const Observer::Params p = params();
  Observer::State s = heated();
  go(s, 1.0, 100, 200e6);
  Observer::State beyond = heated();
  go(beyond, 1.0, 100, 260e6);
  EXPECT_EQ(strain(beyond), strain(s));
  EXPECT_EQ(Observer::estimate(p, s).health, Health::good);
  EXPECT_EQ(Observer::estimate(p, beyond).health, Health::doubtful);
  Observer::State below = heated();
  go(below, 1.0, 100, 5e6);
  EXPECT_EQ(Observer::estimate(p, below).health, Health::doubtful);
}

TEST(StrainResistance, KeepsItsLastWordWithoutAReading) {
  const Observer::Params p = params();
  Observer::State s = heated();
  const double before = strain(s);
  Measurement<double> m = reading(std::nan(""), std::nan(""));
  m.resistance_valid = m.stress_valid = false;
  Observer::advance(p, s, m, 1e-3);
  EXPECT_EQ(strain(s), before);
}

TEST(StrainResistance, FloatIsAsGoodAsDouble) {
  using Small = papers::StrainResistance<float>;
  const Observer::Params p = params();
  Small::Params q{};
  q.martensite_ohm = static_cast<float>(p.martensite_ohm);
  q.min_stress_Pa = static_cast<float>(p.min_stress_Pa);
  q.max_stress_Pa = static_cast<float>(p.max_stress_Pa);
  for (int i = 0; i <= papers::StressPolynomial<float>::order; ++i) {
    q.heating.slope.coefficient[i] = static_cast<float>(p.heating.slope.coefficient[i]);
    q.heating.offset.coefficient[i] = static_cast<float>(p.heating.offset.coefficient[i]);
    q.cooling.slope.coefficient[i] = static_cast<float>(p.cooling.slope.coefficient[i]);
    q.cooling.offset.coefficient[i] = static_cast<float>(p.cooling.offset.coefficient[i]);
  }
  q.initial_slope = static_cast<float>(p.initial_slope);
  q.decay = static_cast<float>(p.decay);
  q.smallest_reversal = static_cast<float>(p.smallest_reversal);
  q.strain_sd = static_cast<float>(p.strain_sd);
  Observer::State s = Observer::start(p, reading(1), 298);
  Small::State t = Small::start(q, {20, 0.001F, 0, 100e6F, true, true, true}, 298);
  for (int i = 0; i < 20000; ++i) {
    const double lambda = 0.95 + 0.07 * std::sin(0.01 * i) * std::sin(0.0031 * i);
    const double stress_Pa = 100e6 + 60e6 * std::sin(0.003 * i);
    Observer::advance(p, s, reading(lambda, stress_Pa), 1e-3);
    Small::advance(q, t,
                   {static_cast<float>(20 * lambda), 0.001F, 0, static_cast<float>(stress_Pa), true,
                    true, true},
                   1e-3F);
    ASSERT_NEAR(strain(s), static_cast<double>(Small::estimate(q, t).strain), 2e-5) << i;
  }
}

}  // namespace
}  // namespace smaservo::strain_resistance_test
