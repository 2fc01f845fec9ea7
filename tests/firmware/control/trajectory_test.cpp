#include "firmware/control/trajectory.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace smaservo::trajectory_test {
namespace {

using Path = Trajectory<double>;

constexpr TrajectorySettings<double> rates{
    .heating_rate_1_s = 0.35, .cooling_rate_1_s = 0.1, .lead_s = 0};
constexpr double dt_s = 1e-3;
constexpr double rounding = 1e-15;

TEST(Trajectory, IsNeverFasterThanItsRatesNorFurtherAheadThanItsLead) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> anywhere(0, 0.05);
  std::normal_distribution<double> normal;
  for (int run = 0; run < 200; ++run) {
    double reference = anywhere(random);
    double strain = reference;
    double setpoint = reference;
    for (int i = 0; i < 500; ++i) {
      if (i % 100 == 0) {
        setpoint = anywhere(random);
      }
      // The estimate follows the reference, and jumps at random now and then.
      strain += i % 170 == 169 ? 0.01 * normal(random) : 0.02 * (reference - strain);
      const Path::Result next = Path::step(rates, reference, setpoint, strain, dt_s);
      ASSERT_LE(next.reference, std::max(strain + Path::lead, setpoint) + rounding);
      ASSERT_LE(next.reference, strain + Path::lead + rounding);
      // The reference exceeds its rates only where the estimate has jumped; then it goes back at
      // once.
      const double from = std::min(reference, strain + Path::lead);
      ASSERT_GE(next.reference, from - rates.heating_rate_1_s * dt_s - rounding);
      ASSERT_LE(next.reference, from + rates.cooling_rate_1_s * dt_s + rounding);
      // The reference never passes the set-point.
      ASSERT_GE(next.reference, std::min(from, setpoint) - rounding);
      ASSERT_LE(next.reference, std::max(from, setpoint) + rounding);
      reference = next.reference;
    }
  }
}

TEST(Trajectory, ReachesTheSetpointToTheBitInTheTimeOfItsRates) {
  const auto steps_to = [](double from, double to) {
    double reference = from;
    int steps = 0;
    while (reference != to && steps < 10000) {
      reference = Path::step(rates, reference, to, reference, dt_s).reference;
      ++steps;
    }
    return steps;
  };
  EXPECT_NEAR(steps_to(0.04, 0.01), 0.03 / 0.35 / dt_s, 1);
  EXPECT_NEAR(steps_to(0.01, 0.04), 0.03 / 0.1 / dt_s, 1);
  EXPECT_EQ(steps_to(0.02, 0.02), 0);
}

TEST(Trajectory, WaitsForAWireThatDoesNotCool) {
  double reference = 0.01;
  int waited = 0;
  for (int i = 0; i < 100; ++i) {
    const Path::Result next = Path::step(rates, reference, 0.04, 0.01, dt_s);
    reference = next.reference;
    waited += next.waits ? 1 : 0;
  }
  EXPECT_DOUBLE_EQ(reference, 0.01 + Path::lead);
  // The reference moves for 8 ms, until it has its lead, and waits from then on.
  EXPECT_NEAR(waited, 100 - Path::lead / 0.1 / dt_s, 1);
}

TEST(Trajectory, DoesNotWaitForHeatNorNearItsGoal) {
  EXPECT_FALSE(Path::step(rates, 0.03, 0.01, 0.04, dt_s).waits);
  EXPECT_FALSE(Path::step(rates, 0.0300, 0.0305, 0.03, dt_s).waits);
  EXPECT_FALSE(Path::step(rates, 0.0305, 0.0305, 0.03, dt_s).waits);
  EXPECT_FALSE(Path::step(rates, 0.03, 0.03, 0.04, dt_s).waits);
}

TEST(Trajectory, AnEstimateThatJumpsTakesTheReferenceAlong) {
  // The estimated strain has jumped to half of what it was; the reference goes on from there.
  const Path::Result next = Path::step(rates, 0.04, 0.05, 0.02, dt_s);
  EXPECT_DOUBLE_EQ(next.reference, 0.02 + Path::lead);
  EXPECT_TRUE(next.waits);
  EXPECT_DOUBLE_EQ(Path::step(rates, 0.04, 0.0, 0.02, dt_s).reference,
                   0.02 + Path::lead - 0.35 * dt_s);
}

}  // namespace
}  // namespace smaservo::trajectory_test
