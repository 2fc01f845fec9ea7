// Bounds on a replay: what they say, what they refuse, and that nothing passes unseen.

#include "host-sim/replay/ci/bounds.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "host-sim/replay/ci/outcome.hpp"
#include "model/files/error.hpp"

namespace smaservo::test::bounds_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A result of one observer with these errors in per cent.
replay::ReplayResult result_of(const std::vector<double>& errors) {
  replay::ReplayResult result;
  result.has_reference = true;
  result.rows = errors.size();
  result.observers = {{"kalman", {}, false}};
  for (const double error : errors) {
    result.observers.front().error.add(error);
  }
  return result;
}

std::string refusal(const std::string& text) {
  try {
    replay::parse_fail_above(text);
  } catch (const files::UserError& error) {
    return error.what();
  }
  return "";
}

TEST(ReplayBounds, AnySubsetOfThree) {
  const replay::Bounds all = replay::parse_fail_above("mean=1,p95=3.5,max=1e1");
  EXPECT_EQ(all.mean_percent, 1);
  EXPECT_EQ(all.p95_percent, 3.5);
  EXPECT_EQ(all.max_percent, 10);
  const replay::Bounds one = replay::parse_fail_above("p95=0");
  EXPECT_EQ(one.p95_percent, 0);
  EXPECT_FALSE(one.mean_percent || one.max_percent);
}

TEST(ReplayBounds, WhatIsWrongIsNamedWithWhatIsAllowed) {
  for (const char* value :
       {"abc", "-1", "nan", "inf", "-inf", "", "1 ", " 1", "1%", "1e3", "0x1", "1e999", "1=2"}) {
    const std::string item = fmt::format("mean={}", value);
    EXPECT_THAT(refusal(item),
                AllOf(HasSubstr("--fail-above " + item + ":"), HasSubstr("between 0 and 999")));
    EXPECT_THAT(refusal("max=1," + item), HasSubstr("--fail-above " + item + ":"));
  }
  for (const char* item : {"median=1", "Mean=1", "mean", "=1", " mean=1"}) {
    EXPECT_THAT(refusal(item), AllOf(HasSubstr(item), HasSubstr("mean=, p95= or max=")));
  }
  for (const char* text : {"", ",", "mean=1,", "mean=1,,max=2"}) {
    EXPECT_THAT(refusal(text), HasSubstr("--fail-above '': must be"));
  }
  EXPECT_THAT(refusal("mean=1,max=2,mean=1"), HasSubstr("mean is given twice"));
}

TEST(ReplayBounds, AValueThatEqualsItsBoundPasses) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> error(0, 50);
  for (int i = 0; i < 500; ++i) {
    // All quantiles on the grid of 0.01 %, as a person writes them.
    const std::string written = fmt::format("{:.2f}", 0.01 * (1 + i));
    const double value = std::stod(written);
    std::vector<double> errors(40, value - 0.005);
    errors.push_back(900);  // above the quantile, which is then not cut to the maximum
    const replay::ReplayResult flat = result_of(errors);
    EXPECT_THAT(misses(replay::parse_fail_above("p95=" + written), flat), IsEmpty()) << written;

    const replay::ReplayResult one = result_of({error(random), error(random), error(random)});
    const replay::ErrorStatistics& e = one.observers.front().error;
    replay::Bounds bounds;
    bounds.mean_percent = e.mean();
    bounds.p95_percent = e.quantile(0.95);
    bounds.max_percent = e.maximum();
    EXPECT_THAT(misses(bounds, one), IsEmpty());
    for (const auto bound : {&replay::Bounds::mean_percent, &replay::Bounds::p95_percent,
                             &replay::Bounds::max_percent}) {
      replay::Bounds tighter = bounds;
      *(tighter.*bound) -= 1e-6;
      EXPECT_THAT(misses(tighter, one), SizeIs(1));
    }
  }
}

TEST(ReplayBounds, AMissSaysBothNumbersSoThatTheyDiffer) {
  const replay::ReplayResult result = result_of({1.0001});
  EXPECT_THAT(misses(replay::parse_fail_above("mean=1,max=0.5"), result),
              ElementsAre("kalman: mean error is 1.0001 %, allowed is 1 %",
                          "kalman: maximum error is 1 %, allowed is 0.5 %"));
}

TEST(ReplayBounds, AnEstimateThatIsNotANumberNeverPasses) {
  for (const double bad : {nan, std::numeric_limits<double>::infinity()}) {
    const replay::ReplayResult result = result_of({0.1, bad});
    EXPECT_THAT(misses(replay::parse_fail_above("mean=999,p95=999,max=999"), result), SizeIs(3));
  }
  replay::Bounds bounds;
  bounds.columns[0] = replay::ColumnBounds{-1e9, 1e9, 0, 1e9};
  replay::ReplayResult result = result_of({0});
  EXPECT_THAT(misses(bounds, result), SizeIs(1)) << "a column without any value";
  result.columns[0].add(0.03);
  EXPECT_THAT(misses(bounds, result), IsEmpty());
  result.columns[0].add(nan);
  EXPECT_THAT(misses(bounds, result), ElementsAre("strain is not a number in 1 rows"));
  result.columns[0].add(-std::numeric_limits<double>::infinity());
  EXPECT_THAT(misses(bounds, result), SizeIs(3));
}

TEST(ReplayBounds, ResistanceMayBeMissingInSomeRows) {
  replay::Bounds bounds;
  bounds.columns[3] = replay::ColumnBounds{20, 30, {}, 0};
  replay::ReplayResult result = result_of({0});
  result.columns[3].add(nan);
  EXPECT_THAT(misses(bounds, result), SizeIs(1));
  result.columns[3].add(20);
  result.columns[3].add(30);
  EXPECT_THAT(misses(bounds, result), IsEmpty());
  result.columns[3].add(30.1);
  EXPECT_THAT(misses(bounds, result),
              ElementsAre("the greatest resistance_ohm is 30.1, allowed is 30"));
}

TEST(ReplayBounds, WhatCannotBeJudgedIsAnError) {
  const replay::Bounds bounds = replay::parse_fail_above("mean=1");
  replay::ReplayResult empty = result_of({});
  EXPECT_THROW(misses(bounds, empty), files::UserError) << "a mean of nothing is no mean of 0";
  empty.has_reference = false;
  EXPECT_THROW(misses(bounds, empty), files::UserError);
  replay::Bounds of_line = bounds;
  of_line.observer = "line";
  EXPECT_THROW(misses(of_line, result_of({0})), files::UserError);
}

TEST(ReplayBounds, RowsAreCounted) {
  replay::Bounds bounds;
  bounds.rows = 2;
  bounds.max_skipped = 3;
  bounds.max_invalid = 0;
  replay::ReplayResult result = result_of({0, 0});
  result.skipped = 3;
  EXPECT_THAT(misses(bounds, result), IsEmpty());
  result.rows = 3;
  result.skipped = 4;
  result.invalid = 1;
  EXPECT_THAT(misses(bounds, result),
              ElementsAre("has 3 rows, expected are 2", "4 rows were skipped, allowed are 3",
                          "1 rows have no valid resistance, allowed are 0"));
}

TEST(ReplayBounds, TheWorstExitStatusCounts) {
  const replay::Outcome good;
  replay::Outcome missed, mistaken, lost;
  missed.misses = {"a bound"};
  mistaken.errors = {"no file"};
  lost.lost = "all observers were lost";
  const auto status = [](const std::vector<replay::Outcome>& all) {
    return replay::exit_status(all);
  };
  EXPECT_EQ(status({good, good}), 0);
  EXPECT_EQ(status({good, lost}), 3);
  EXPECT_EQ(status({lost, missed, good}), 1);
  EXPECT_EQ(status({mistaken, lost}), 1);
}

}  // namespace
}  // namespace smaservo::test::bounds_test
