// Whole devices on simulated wires: the shipped scenarios.

#include "firmware/bench/closed_loop.hpp"

#include <gtest/gtest.h>

#include "tests/firmware/bench/scenario/shipped_scenarios.hpp"

namespace smaservo::test {
namespace {

class ShippedLoop : public ::testing::TestWithParam<std::string> {};

TEST_P(ShippedLoop, StaysFiniteAndCool) {
  const bench::ClosedLoopScenario scenario = shipped_scenario(GetParam());
  const double limit_K = scenario.settings.limits.temperature_K;
  bench::ClosedLoop loop(scenario);
  double moved = 0;
  double first = 0;
  while (loop.step()) {
    const bench::SimulatedCycle& cycle = loop.cycle();
    first = cycle.time_s == 0 ? cycle.truth.strain : first;
    moved = std::max(moved, first - cycle.truth.strain);
    ASSERT_LT(cycle.truth.hottest_K, limit_K + 3) << "at " << cycle.time_s << " s";
    if (const auto other = loop.other()) {
      ASSERT_LT(other->hottest_K, limit_K + 3) << "at " << cycle.time_s << " s";
    }
    ASSERT_TRUE(std::isfinite(cycle.output.drive_current_A)) << cycle.time_s;
    ASSERT_TRUE(std::isfinite(cycle.output.drive_voltage_V)) << cycle.time_s;
    ASSERT_TRUE(std::isfinite(cycle.truth.strain)) << cycle.time_s;
    ASSERT_GE(cycle.output.drive_current_A, 0);
    if (cycle.time_s > 0.05) {
      ASSERT_TRUE(std::isfinite(cycle.output.estimate.strain)) << cycle.time_s;
    }
  }
  EXPECT_GT(moved, 0.004) << "nothing has happened";
}

INSTANTIATE_TEST_SUITE_P(Shipped, ShippedLoop, ::testing::ValuesIn(scenario_names()), suffix);

TEST(ClosedLoop, WithoutPowerThereIsNoCurrentAndNoMemory) {
  bench::ClosedLoopScenario scenario = shipped_scenario("steps");
  scenario.duration_s = 2;
  bench::SimEvent& power_cut = scenario.events.emplace_back();
  power_cut.at_s = 1;
  power_cut.for_s = 0.1;
  power_cut.reboots = true;
  bench::ClosedLoop loop(scenario);
  double before_A = 0;
  while (loop.step()) {
    const bench::SimulatedCycle& cycle = loop.cycle();
    const double between_s = cycle.time_s - 0.0005;  // events come between two steps
    if (between_s < 1) {
      before_A = std::max(before_A, cycle.output.drive_current_A);
    } else if (between_s < 1.1) {
      ASSERT_EQ(cycle.output.drive_current_A, 0) << cycle.time_s;
      ASSERT_LE(cycle.output.time_us, 2000U) << "a new device's first step";
    } else {
      ASSERT_EQ(cycle.output.first_cause, Fault::none) << cycle.time_s;
    }
  }
  EXPECT_GT(before_A, 0.05);
  EXPECT_NEAR(static_cast<double>(loop.cycle().output.time_us), 0.9e6, 2e3);
}

}  // namespace
}  // namespace smaservo::test
