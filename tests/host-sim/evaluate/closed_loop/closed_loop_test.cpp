#include "host-sim/evaluate/closed_loop/closed_loop.hpp"

#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/places.hpp"

namespace smaservo::evaluate {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Two units with wires that identify has found.
ClosedLoopOptions golden_units() {
  ClosedLoopOptions options;
  options.units = 1;
  options.runs = 2;
  options.steps = 4;
  options.random = 2;
  options.wires = test::source_folder() + "/tests/golden/evaluate";
  return options;
}

/// All in one test: each is a process of its own, and the runs are the cost.
TEST(ClosedLoopEvaluation, TheDeviceHoldsWhatTheOthersDoNot) {
  ClosedLoopOptions options = golden_units();
  const ClosedLoopEvaluation evaluation = evaluate_closed_loop(options);
  ASSERT_EQ(evaluation.rows.size(), closed_loop_rows.size());
  for (const LoopRowResult& row : evaluation.rows) {
    const auto& [device, ideal, resistance, position_002] = row.kinds;
    for (const LoopFigures& figures : row.kinds) {
      EXPECT_EQ(figures.heating_s.size() + figures.cooling_s.size(), 8U);
      EXPECT_TRUE(std::ranges::is_sorted(figures.heating_s));
    }
    // What has become too good has probably become wrong.
    EXPECT_LT(device.error.mean(), 2.5);
    EXPECT_GT(device.error.mean(), 0.05);
    EXPECT_LT(ideal.error.mean(), 0.3);
    EXPECT_LT(device.error.mean(), resistance.error.mean());
    EXPECT_EQ(device.cycles, 0);
    EXPECT_TRUE(device.trips.empty());
    EXPECT_TRUE(ideal.trips.empty());
    EXPECT_LT(device.above_limit_K, 3);
    EXPECT_EQ(ideal.cooled_in_time, static_cast<int>(ideal.cooling_s.size()));
    // A run of each family.
    const auto& [ihyp, sublayers] = row.device_by_family;
    EXPECT_EQ(ihyp.error.count(), 4U);
    EXPECT_EQ(sublayers.error.count(), 4U);
    EXPECT_NEAR((ihyp.error.mean() + sublayers.error.mean()) / 2, device.error.mean(), 1e-9);
    EXPECT_EQ(ihyp.cooled_in_time + sublayers.cooled_in_time, device.cooled_in_time);
    EXPECT_EQ(std::max(ihyp.above_limit_K, sublayers.above_limit_K), device.above_limit_K);
  }
  for (const double Hz : evaluation.bandwidth_Hz.front()) {
    EXPECT_GT(Hz, 2);
    EXPECT_LT(Hz, 4.5);
  }
  options.threads = 2;
  EXPECT_EQ(closed_loop_json(evaluate_closed_loop(options)), closed_loop_json(evaluation));
  EXPECT_THAT(closed_loop_markdown(evaluation), HasSubstr("| spring | ideal sensor | all |"));
  EXPECT_THAT(closed_loop_markdown(evaluation), HasSubstr("| spring | device | sublayers |"));

  // A single run is of the first family.
  options.runs = options.steps = 1;
  options.random = 0;
  const ClosedLoopEvaluation one = evaluate_closed_loop(options);
  EXPECT_EQ(one.rows.front().device_by_family[0].error.count(), 1U);
  EXPECT_EQ(one.rows.front().device_by_family[1].error.count(), 0U);
  EXPECT_THAT(closed_loop_markdown(one), Not(HasSubstr("sublayers")));
}

}  // namespace
}  // namespace smaservo::evaluate
