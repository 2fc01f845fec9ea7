#include "firmware/parameters/staging.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "tests/firmware/parameters/random_settings.hpp"

namespace smaservo::staging_test {
namespace {

constexpr bool enabled = true;
constexpr bool disabled = false;

Key key(std::string_view path) {
  return parameters<double>[find_parameter(path)].key;
}

StageResult stage(Staging<double>& staging, std::string_view path, float value,
                  bool is_enabled = disabled) {
  return staging.stage(key(path), Value::real(value), is_enabled);
}

TEST(Staging, NothingHappensBeforeApply) {
  OwnSettings<double> own(reference_settings());
  Staging<double> staging(own);
  EXPECT_EQ(stage(staging, "strain.proportional_W", 100), StageResult::ok);
  EXPECT_TRUE(same_settings(staging.active(), reference_settings()));
  EXPECT_TRUE(same_settings(staging.configured(), reference_settings()));
  EXPECT_EQ(staging.staged().strain.proportional, 100);
  EXPECT_TRUE(staging.apply(enabled).ok());
  EXPECT_EQ(staging.active().strain.proportional, 100);
  EXPECT_EQ(staging.configured().strain.proportional, 100);
}

TEST(Staging, ABadValueLeavesEverythingAsItWas) {
  OwnSettings<double> own(reference_settings());
  Staging<double> staging(own);
  stage(staging, "limits.current_A", 0.12F);
  const Settings<double> before = staging.staged();
  const float inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(stage(staging, "limits.current_A", 21), StageResult::above);
  EXPECT_EQ(stage(staging, "limits.current_A", 0), StageResult::below);
  EXPECT_EQ(stage(staging, "limits.current_A", std::nanf("")), StageResult::not_finite);
  EXPECT_EQ(stage(staging, "limits.current_A", -inf), StageResult::not_finite);
  EXPECT_EQ(stage(staging, "wire.length_m", std::nanf("")), StageResult::not_finite);
  EXPECT_EQ(staging.stage(Key{0x2020, 99}, Value::real(1), disabled),
            StageResult::unknown_parameter);
  EXPECT_EQ(staging.stage(key("safe.state"), Value::number(3), disabled), StageResult::above);
  EXPECT_TRUE(same_settings(staging.staged(), before));
}

TEST(Staging, ASetThatContradictsItselfIsRefusedAsAWhole) {
  OwnSettings<double> own(reference_settings());
  Staging<double> staging(own);
  stage(staging, "strain.proportional_W", 100);
  stage(staging, "limits.current_A", 0.2F);
  const Applied refused = staging.apply(disabled);
  EXPECT_EQ(refused.problem, ApplyProblem::refused);
  EXPECT_EQ(refused.finding.parameter, find_parameter("limits.current_A"));
  EXPECT_EQ(refused.finding.other, find_parameter("trips.current_A"));
  EXPECT_TRUE(same_settings(staging.active(), reference_settings()));
  EXPECT_EQ(stage(staging, "trips.current_A", 0.3F), StageResult::ok)
      << "the order does not matter";
  EXPECT_TRUE(staging.apply(disabled).ok());
  EXPECT_EQ(staging.active().strain.proportional, 100);
  EXPECT_EQ(staging.active().trips.current_A, static_cast<double>(0.3F));
}

TEST(Staging, DiscardForgetsWhatIsStaged) {
  OwnSettings<double> own(reference_settings());
  Staging<double> staging(own);
  stage(staging, "limits.current_A", 5);
  staging.discard();
  EXPECT_TRUE(same_settings(staging.staged(), reference_settings()));
  EXPECT_TRUE(staging.apply(enabled).ok());
  EXPECT_TRUE(same_settings(staging.active(), reference_settings()));
}

/// Of every parameter: what may change when.
TEST(Staging, ChangeRulesHoldForEveryParameter) {
  std::mt19937 random(11);
  const Settings<double> other = random_settings(random);
  std::array<int, 3> tried{};
  for (const Parameter<double>& row : parameters<double>) {
    OwnSettings<double> own(reference_settings());
    Staging<double> staging(own);
    const Value now = row.get(staging.active());
    const Value value = row.get(other);
    if (value == now || !row.is_used(other)) {
      continue;
    }
    ++tried[static_cast<std::size_t>(row.change)];
    const bool with_current = row.change != Change::without_current;
    EXPECT_EQ(staging.stage(row.key, now, enabled), StageResult::ok) << "it changes nothing";
    EXPECT_EQ(staging.stage(row.key, value, enabled),
              with_current ? StageResult::ok : StageResult::while_enabled)
        << row.path.text();
    EXPECT_EQ(staging.stage(row.key, value, disabled), StageResult::ok);
    // Enabled in between: it is refused then, or whenever the set is contradictory.
    if (!with_current) {
      EXPECT_EQ(staging.apply(enabled).problem, ApplyProblem::while_enabled);
      EXPECT_EQ(row.get(staging.active()), now);
    }
    const bool applied = staging.apply(disabled).ok();
    const bool at_once = applied && row.change != Change::after_reset;
    EXPECT_EQ(row.get(staging.active()), at_once ? value : now) << row.path.text();
    EXPECT_EQ(row.get(staging.configured()), applied ? value : now);
    EXPECT_EQ(staging.waits_for_reset(), applied && row.change == Change::after_reset);
  }
  EXPECT_GT(tried[0], 20);
  EXPECT_GT(tried[1], 50);
  EXPECT_GE(tried[2], 2);
}

TEST(Staging, WhatWaitsForAResetComesWithIt) {
  OwnSettings<double> own(reference_settings());
  Staging<double> staging(own);
  staging.stage(key("identity.node_id"), Value::number(9), enabled);
  stage(staging, "strain.integral_1_s", 3);
  EXPECT_TRUE(staging.apply(enabled).ok());
  EXPECT_EQ(staging.active().identity.node_id, 1U);
  EXPECT_EQ(staging.active().strain.integral_1_s, 3);
  EXPECT_TRUE(staging.waits_for_reset());
  staging.restart(staging.configured());
  EXPECT_EQ(staging.active().identity.node_id, 9U);
  EXPECT_FALSE(staging.waits_for_reset());
}

TEST(Staging, NewValuesMustAlsoDoWithWhatWaits) {
  OwnSettings<double> own(reference_settings());
  Staging<double> staging(own);
  stage(staging, "timing.period_s", 2e-4F);
  stage(staging, "timing.sample_timeout_s", 1e-3F);
  const Applied refused = staging.apply(disabled);
  EXPECT_EQ(refused.problem, ApplyProblem::refused) << "until the reset the period is 1 ms";
  EXPECT_EQ(refused.finding.parameter, find_parameter("timing.period_s"));
}

TEST(Staging, ATrialGoesBackByItself) {
  OwnSettings<double> own(reference_settings());
  Staging<double> staging(own);
  stage(staging, "strain.proportional_W", 100, enabled);
  ASSERT_TRUE(staging.try_for(30).ok());
  EXPECT_EQ(staging.active().strain.proportional, 100);
  EXPECT_TRUE(same_settings(staging.configured(), reference_settings())) << "nothing to store yet";
  int steps = 0;
  while (!staging.tick(1e-3)) {
    ASSERT_EQ(staging.active().strain.proportional, 100);
    ASSERT_LT(++steps, 31000);
  }
  EXPECT_NEAR(steps, 30000, 1);
  EXPECT_TRUE(same_settings(staging.active(), reference_settings()));
  EXPECT_TRUE(same_settings(staging.staged(), reference_settings()));
  EXPECT_FALSE(staging.on_trial());
  EXPECT_FALSE(staging.tick(1e-3)) << "once";
  EXPECT_EQ(staging.commit().problem, ApplyProblem::no_trial) << "too late";
}

TEST(Staging, CountsWhatComesIntoForce) {
  OwnSettings<double> own(reference_settings());
  Staging<double> staging(own);
  EXPECT_EQ(own.changes(), 0U);
  stage(staging, "strain.proportional_W", 100, enabled);
  EXPECT_EQ(own.changes(), 0U);
  ASSERT_TRUE(staging.apply(enabled).ok());
  EXPECT_EQ(own.changes(), 1U);
  stage(staging, "strain.proportional_W", 110, enabled);
  ASSERT_TRUE(staging.try_for(1).ok());
  EXPECT_TRUE(staging.tick(2));
  EXPECT_EQ(own.changes(), 3U) << "the trial, and its end";
  staging.replace(reference_settings());
  EXPECT_EQ(own.changes(), 4U);
}

TEST(Staging, WhatWaitsForTheNextStartGoesOnWaiting) {
  OwnSettings<double> own(reference_settings());
  Staging<double> staging(own);
  ASSERT_EQ(staging.stage(key("identity.node_id"), Value::number(17), enabled), StageResult::ok);
  ASSERT_TRUE(staging.apply(enabled).ok());
  Settings<double> given = reference_settings();
  given.strain.proportional = 100;
  staging.replace(given);
  EXPECT_EQ(staging.configured().identity.node_id, 17U);
  EXPECT_EQ(staging.active().identity.node_id, reference_settings().identity.node_id);
  EXPECT_EQ(staging.active().strain.proportional, 100);
}

TEST(Staging, ACommittedTrialStays) {
  OwnSettings<double> own(reference_settings());
  Staging<double> staging(own);
  stage(staging, "strain.proportional_W", 100, enabled);
  ASSERT_TRUE(staging.try_for(1).ok());
  EXPECT_FALSE(staging.tick(0.9));
  EXPECT_TRUE(staging.commit().ok());
  EXPECT_FALSE(staging.tick(10));
  EXPECT_EQ(staging.active().strain.proportional, 100);
  EXPECT_EQ(staging.configured().strain.proportional, 100);
}

TEST(Staging, TrialsInARowGoBackToTheFirstStart) {
  OwnSettings<double> own(reference_settings());
  Staging<double> staging(own);
  for (const float gain : {100.F, 200.F, 300.F}) {
    stage(staging, "strain.proportional_W", gain, enabled);
    ASSERT_TRUE(staging.try_for(1).ok());
    EXPECT_FALSE(staging.tick(0.9)) << "each has its own time";
    EXPECT_EQ(staging.active().strain.proportional, static_cast<double>(gain));
  }
  EXPECT_EQ(staging.apply(enabled).problem, ApplyProblem::on_trial);
  EXPECT_TRUE(staging.tick(0.2));
  EXPECT_TRUE(same_settings(staging.active(), reference_settings()));
}

TEST(Staging, OnlyWhatIsTriedIsCommitted) {
  OwnSettings<double> own(reference_settings());
  Staging<double> staging(own);
  stage(staging, "strain.proportional_W", 100, enabled);
  ASSERT_TRUE(staging.try_for(1).ok());
  stage(staging, "strain.integral_1_s", 5, enabled);
  EXPECT_TRUE(staging.commit().ok());
  EXPECT_EQ(staging.configured().strain.integral_1_s, 0) << "staged after the trial began";
  EXPECT_EQ(staging.staged().strain.integral_1_s, 5);
  EXPECT_TRUE(staging.apply(enabled).ok());
  EXPECT_EQ(staging.active().strain.integral_1_s, 5);
}

TEST(Staging, ATrialTakesLiveParametersThatDoTogether) {
  OwnSettings<double> own(reference_settings());
  Staging<double> staging(own);
  EXPECT_EQ(staging.try_for(0).problem, ApplyProblem::duration);
  EXPECT_EQ(staging.try_for(std::nan("")).problem, ApplyProblem::duration);
  EXPECT_EQ(staging.try_for(1e6).problem, ApplyProblem::duration);
  stage(staging, "wire.length_m", 0.2F);
  const Applied refused = staging.try_for(1);
  EXPECT_EQ(refused.problem, ApplyProblem::only_live);
  EXPECT_EQ(refused.parameter, find_parameter("wire.length_m"));
  staging.discard();
  stage(staging, "limits.min_strain", 0.06F);
  EXPECT_EQ(staging.try_for(1).problem, ApplyProblem::refused);
  EXPECT_FALSE(staging.on_trial());
  EXPECT_TRUE(same_settings(staging.active(), reference_settings()));
}

/// Whatever is asked for in whatever order: what is in force and what is stored pass every check,
/// and without a trial they differ in nothing but what waits for a reset.
TEST(Staging, StaysConsistentThroughRandomCalls) {
  std::mt19937 random(12);
  const Settings<double> start = reference_settings();
  OwnSettings<double> own(start);
  Staging<double> staging(own);
  std::size_t applied = 0;
  std::size_t reverted = 0;
  for (int i = 0; i < 4000; ++i) {
    const bool is_enabled = random() % 2 == 0;
    const Settings<double> active = staging.active();
    switch (random() % 8) {
      case 0:
        applied += staging.apply(is_enabled).ok() ? 1U : 0U;
        break;
      case 1:
        applied += staging.try_for(1).ok() ? 1U : 0U;
        break;
      case 2:
        staging.commit();
        break;
      case 3:
        staging.discard();
        break;
      case 4:
        reverted += staging.tick(0.6) ? 1U : 0U;
        break;
      default: {
        const Parameter<double>& row = parameters<double>[random() % parameter_count];
        staging.stage(row.key, random_value(row, row.get(staging.staged()), random), is_enabled);
        ASSERT_TRUE(same_settings(staging.active(), active));
      }
    }
    ASSERT_TRUE(check(staging.active()).ok());
    ASSERT_TRUE(check(staging.configured()).ok());
    for (const Parameter<double>& row : parameters<double>) {
      if (row.change == Change::after_reset) {
        ASSERT_EQ(row.get(staging.active()), row.get(start));
      } else if (!staging.on_trial() || row.change == Change::without_current) {
        ASSERT_EQ(row.get(staging.active()), row.get(staging.configured()));
      }
    }
  }
  EXPECT_GT(applied, 100U);
  EXPECT_GT(reverted, 20U);
}

}  // namespace
}  // namespace smaservo::staging_test
