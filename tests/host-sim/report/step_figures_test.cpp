#include "host-sim/report/step_figures.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace smaservo::report {
namespace {

constexpr double stroke = 0.04;
constexpr double period_s = 1e-3;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A first-order way from 3 % to this set-point with time constant 50 ms, for one second.
void follow(StepJudge& judge, double& time_s, double& strain, double setpoint, double offset = 0) {
  for (int i = 0; i < 1000; ++i, time_s += period_s) {
    judge.add(time_s, setpoint, strain);
    strain += (setpoint + offset - strain) * (1 - std::exp(-period_s / 0.05));
  }
}

TEST(StepJudge, KnowsAFirstOrderStep) {
  StepJudge judge(stroke, period_s);
  double time_s = 0;
  double strain = 0.03;
  follow(judge, time_s, strain, 0.03);
  follow(judge, time_s, strain, 0.01);
  judge.finish();
  ASSERT_EQ(judge.steps().size(), 2U);
  const StepFigures& step = judge.steps()[1];
  EXPECT_NEAR(step.from_s, 1, 1e-9);
  EXPECT_NEAR(step.seconds, 1, 1e-9);
  EXPECT_EQ(step.from, 0.03);
  EXPECT_EQ(step.to, 0.01);
  EXPECT_NEAR(step.rise_s, 0.05 * std::log(9.0), 2e-3);
  // From 50 % of the stroke into a band of 2 % of it.
  EXPECT_NEAR(step.settling_s, 0.05 * std::log(25.0), 2e-3);
  EXPECT_EQ(step.overshoot_percent, 0);
  EXPECT_NEAR(step.error_percent, 0, 1e-3);
  EXPECT_TRUE(std::isnan(judge.steps()[0].rise_s)) << "there was no way to go";
  EXPECT_EQ(judge.steps()[0].settling_s, 0);
}

TEST(StepJudge, SeesOvershootAndWhatNeverSettles) {
  StepJudge judge(stroke, period_s);
  double time_s = 0;
  double strain = 0.01;
  follow(judge, time_s, strain, 0.02, 0.002);
  judge.finish();
  const StepFigures& step = judge.steps().at(0);
  EXPECT_NEAR(step.overshoot_percent, 5, 1e-3);
  EXPECT_NEAR(step.error_percent, 5, 1e-3);
  EXPECT_TRUE(std::isnan(step.settling_s));
}

TEST(StepJudge, LeavesOutWhatMovesAndWhatIsNotControlled) {
  StepJudge judge(stroke, period_s);
  double time_s = 0;
  for (int i = 0; i < 2000; ++i, time_s += period_s) {
    judge.add(time_s, 0.02 + 1e-6 * i, 0.02);
  }
  for (int i = 0; i < 1000; ++i, time_s += period_s) {
    judge.add(time_s, nan, 0.02);
  }
  judge.finish();
  EXPECT_TRUE(judge.steps().empty());
}

/// A limit that acts in most of the last quarter holds the wire; one that has acted before, or now
/// and then, does not.
TEST(StepJudge, TellsWhichLimitsActedAtTheEnd) {
  StepJudge judge(stroke, period_s);
  const int rows = 1000;
  for (int i = 0; i < rows; ++i) {
    const std::uint32_t before = i < 700 ? 1U << 0U : 0U;
    const std::uint32_t now_and_then = i % 5 < 2 ? 1U << 3U : 0U;
    const std::uint32_t mostly = i % 5 < 3 ? 1U << 4U : 0U;
    const std::uint32_t lasting = i >= 750 ? 1U << 9U : 0U;
    judge.add(i * period_s, 0.01, 0.02, {0.012, 0.019, before | now_and_then | mostly | lasting});
  }
  judge.finish();
  ASSERT_EQ(judge.steps().size(), 1U);
  const StepFigures& step = judge.steps()[0];
  EXPECT_EQ(step.limits, 1U << 4U | 1U << 9U);
  EXPECT_EQ(step.held, 0.012);
  EXPECT_EQ(step.estimate, 0.019);
  EXPECT_EQ(step.end, 0.02);
  EXPECT_TRUE(is_unreached(step));
}

}  // namespace
}  // namespace smaservo::report
