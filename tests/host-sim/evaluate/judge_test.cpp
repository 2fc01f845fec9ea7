#include "host-sim/evaluate/judge.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "host-sim/evaluate/rows.hpp"

namespace smaservo::test {
namespace {

constexpr double stroke = 0.04;

/// 100 Hz; strain and error as functions of time, both in % of the stroke.
std::vector<evaluate::JudgedRow> run(double seconds, const auto& strain_percent,
                                     const auto& error_percent) {
  std::vector<evaluate::JudgedRow> rows;
  for (int i = 0; i <= std::lround(100 * seconds); ++i) {
    const double t = 0.01 * i;
    const double strain = stroke * strain_percent(t) / 100;
    rows.push_back({t, strain, strain + stroke * error_percent(t) / 100, 0, Health::good});
  }
  return rows;
}
double rest(double /*time_s*/) {
  return 50;
}

TEST(JudgeErrors, CountsAfterTheFirstSecond) {
  // 101 rows are left out; of the other 200 every second one is 1 % wrong, the others 3 %.
  auto rows = run(3, rest, [](double t) {
    return t < 1.005 ? 90 : std::lround(100 * t) % 2 == 0 ? 1 : -3;
  });
  const evaluate::RunFigures figures = evaluate::judge_errors(rows, stroke);
  EXPECT_EQ(figures.error.count(), 200U);
  EXPECT_NEAR(figures.error.mean(), 2, 1e-9);
  EXPECT_NEAR(figures.error.maximum(), 3, 1e-9);
  EXPECT_FALSE(figures.lost);
}

/// A servo that takes the cold wire as its zero.
TEST(JudgeErrors, CountsTheDisplacementFromTheFirstRestOn) {
  auto rows = run(3, rest, [](double t) { return t < 0.195 ? 5 : t < 2 ? 6 : 3; });
  const auto figures = [&](evaluate::Counted counted) {
    return evaluate::judge_errors(rows, stroke, counted);
  };
  EXPECT_NEAR(figures(evaluate::Counted::displacement).error.maximum(), 2, 1e-9);
  EXPECT_NEAR(figures(evaluate::Counted::displacement).error.mean(), 1.5, 0.01);
  EXPECT_NEAR(figures(evaluate::Counted::strain).error.maximum(), 6, 1e-9);
  EXPECT_EQ(figures(evaluate::Counted::displacement).within_2_sd,
            figures(evaluate::Counted::strain).within_2_sd);
}

/// An observer program may answer nothing at first.
TEST(JudgeErrors, TheZeroIsThatOfTheRowsWithAnEstimate) {
  auto rows = run(3, rest, [](double t) { return t < 1 ? 5 : 7; });
  for (std::size_t i = 0; i < 15; ++i) {
    rows[i].estimate = std::numeric_limits<double>::quiet_NaN();
  }
  const auto displacement = [&] {
    return evaluate::judge_errors(rows, stroke, evaluate::Counted::displacement);
  };
  EXPECT_NEAR(displacement().error.mean(), 2, 1e-9);
  EXPECT_FALSE(displacement().lost);
  // Without any there is no zero.
  for (std::size_t i = 0; i < 20; ++i) {
    rows[i].estimate = std::numeric_limits<double>::quiet_NaN();
  }
  EXPECT_TRUE(displacement().lost);
}

TEST(JudgeErrors, CountsWhatIsInsideOfTwoDeviations) {
  auto rows = run(3, rest, [](double) { return 2; });
  for (std::size_t i = 0; i < rows.size(); ++i) {
    // 2 % are inside of twice 1.1 %, not of twice 0.9 %.
    rows[i].estimate_sd = stroke / 100 * (i % 4 == 0 ? 0.9 : 1.1);
  }
  rows[299].estimate_sd = rows[298].estimate_sd = std::numeric_limits<double>::quiet_NaN();
  const evaluate::RunFigures figures = evaluate::judge_errors(rows, stroke);
  EXPECT_EQ(figures.with_sd, 198U);
  EXPECT_EQ(figures.within_2_sd, 148U);
}

TEST(JudgeErrors, RunIsLostAboveTwentyPercentOrWithoutANumber) {
  const auto once = [](double error) {
    auto rows = run(3, rest, [](double) { return 0; });
    rows[200].estimate += stroke * error / 100;
    return evaluate::judge_errors(rows, stroke).lost;
  };
  EXPECT_FALSE(once(-19.9));
  EXPECT_TRUE(once(-20.1));
  EXPECT_TRUE(once(std::numeric_limits<double>::quiet_NaN()));
}

TEST(HoldDrift, IsBetweenTheSecondAndTheLastSecondOfTheRipple) {
  // -1 % in the second second of a ripple from 3 s to 13 s, then 0.2 % more each second.
  const auto rows =
      run(20, rest, [](double t) { return t < 4 ? 40 : -1 + 0.2 * std::floor(t + 1e-9 - 4); });
  EXPECT_NEAR(evaluate::hold_drift_percent(rows, stroke, 3, 13), 0.2 * 8, 1e-9);
}

/// Contracts in one second from 3 s on, at rest otherwise.
double contraction(double t) {
  return t < 3 ? 100 : t < 4 ? 100 - 100 * (t - 3) : 0;
}

TEST(UnknownStart, TimeCountsWhileTheWireMoves) {
  const auto rows = run(10, contraction, [](double t) { return t < 3.495 ? 10 : 5; });
  const evaluate::StartFigures start = evaluate::judge_start(rows, stroke);
  EXPECT_NEAR(start.found_after_s, 0.5, 0.02);
  EXPECT_FALSE(start.locked);
  EXPECT_TRUE(start.sure);
}

TEST(UnknownStart, PassingThroughIsNotFinding) {
  const auto passes = run(10, contraction, [](double t) { return t > 3.2 && t < 3.65 ? 0 : 10; });
  EXPECT_TRUE(std::isinf(evaluate::judge_start(passes, stroke).found_after_s));
  EXPECT_TRUE(evaluate::judge_start(passes, stroke).locked);
  const auto stays = run(10, contraction, [](double t) { return t > 3.2 && t < 3.75 ? 0 : 10; });
  EXPECT_NEAR(evaluate::judge_start(stays, stroke).found_after_s, 0.2, 0.03);
  EXPECT_TRUE(evaluate::judge_start(stays, stroke).locked) << "it has gone astray to the end";
}

TEST(UnknownStart, IsAskedOneSecondAfterTheFirstHeating) {
  // Within 10 % of its shortest at 3.9 s.
  const auto sure = [](double good_from_s) {
    auto rows = run(10, contraction, [](double) { return 0; });
    for (evaluate::JudgedRow& row : rows) {
      row.health = row.time_s < good_from_s ? Health::searching : Health::good;
    }
    return evaluate::judge_start(rows, stroke).sure;
  };
  EXPECT_TRUE(sure(4.85));
  EXPECT_FALSE(sure(4.95));
}

evaluate::RowFigures pooled(const std::vector<evaluate::JudgedRun>& runs) {
  evaluate::PooledRuns all;
  for (const evaluate::JudgedRun& run : runs) {
    all.add(run);
  }
  return all.figures();
}

TEST(PooledRuns, CountByTheirInstants) {
  const auto judged = [](double seconds, double error, evaluate::Condition condition) {
    evaluate::JudgedRun one{};
    one.run.condition = condition;
    one.figures = evaluate::judge_errors(run(seconds, rest, [&](double) { return error; }), stroke);
    return one;
  };
  std::vector<evaluate::JudgedRun> runs{judged(2, 1, evaluate::Condition::hold_ripple),
                                        judged(4, 3, evaluate::Condition::hold_ripple),
                                        judged(2, 25, evaluate::Condition::hold_ripple)};
  runs[0].drift_percent = -0.4;
  runs[1].drift_percent = 0.1;
  runs[2].drift_percent = 0.7;
  const evaluate::RowFigures row = pooled(runs);
  EXPECT_EQ(row.runs, 3);
  EXPECT_EQ(row.lost, 1);
  EXPECT_EQ(row.error.count(), 500U);
  EXPECT_NEAR(row.error.mean(), (100 * 1 + 300 * 3 + 100 * 25) / 500.0, 1e-9);
  EXPECT_NEAR(row.error.quantile(0.5), 3, 0.011);
  EXPECT_NEAR(row.drift_mean, 0.4, 1e-12);
  EXPECT_EQ(row.drift_p95, 0.7);
  EXPECT_EQ(row.drift_maximum, 0.7);
  EXPECT_TRUE(std::isnan(row.found_median_s));
}

TEST(PooledRuns, HaveMedianAndNinetyPerCentOfStarts) {
  std::vector<evaluate::JudgedRun> runs(10);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    runs[i].run.condition = evaluate::Condition::unknown_start;
    runs[i].start = evaluate::StartFigures{
        i == 3 ? std::numeric_limits<double>::infinity() : 0.1 * static_cast<double>(i), i == 3,
        i != 5};
  }
  const evaluate::RowFigures row = pooled(runs);
  EXPECT_NEAR(row.found_median_s, 0.5, 1e-12);
  EXPECT_NEAR(row.found_p90_s, 0.9, 1e-12);
  EXPECT_EQ(row.locked, 1);
  EXPECT_EQ(row.unsure, 1);
}

}  // namespace
}  // namespace smaservo::test
