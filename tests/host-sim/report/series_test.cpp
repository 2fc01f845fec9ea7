#include "host-sim/report/series.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "host-sim/report/gnuplot.hpp"

namespace smaservo::test {
namespace {

using Series = report::SeriesOf<report::PlotPoint, &report::PlotPoint::strain_percent>;

report::PlotPoint point(double time_s, double strain_percent) {
  report::PlotPoint p{};
  p.time_s = time_s;
  p.strain_percent = strain_percent;
  p.resistance_ohm = 2 * time_s;  // belongs to this point only
  return p;
}

std::vector<double> random_walk(std::size_t rows, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> step;
  std::vector<double> strain{0};
  while (strain.size() < rows) {
    strain.push_back(strain.back() + step(random));
  }
  return strain;
}

Series filled(const std::vector<double>& strain, std::size_t max) {
  Series series(max);
  for (std::size_t i = 0; i < strain.size(); ++i) {
    series.add(point(static_cast<double>(i), strain[i]));
  }
  return series;
}

TEST(Series, KeepsAllOfAShortRun) {
  const std::vector<double> strain = random_walk(2000, 1);
  const std::vector<report::PlotPoint> points = filled(strain, 4096).points();
  ASSERT_EQ(points.size(), strain.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(points[i].strain_percent, strain[i]);
  }
  EXPECT_TRUE(Series().points().empty());
}

TEST(Series, PointsAreRowsInOrder) {
  const std::vector<double> strain = random_walk(100'000, 2);
  double last = -1;
  for (const report::PlotPoint& p : filled(strain, 4096).points()) {
    ASSERT_GT(p.time_s, last);
    last = p.time_s;
    ASSERT_EQ(p.strain_percent, strain[static_cast<std::size_t>(p.time_s)]);
    ASSERT_EQ(p.resistance_ohm, 2 * p.time_s);
  }
}

TEST(Series, SizeStaysConstantAndUseful) {
  const std::vector<double> strain = random_walk(300'000, 3);
  Series series(1000);
  for (std::size_t i = 0; i < strain.size(); ++i) {
    series.add(point(static_cast<double>(i), strain[i]));
    if (i % 1009 == 0 && i > 2000) {
      const std::size_t size = series.points().size();
      ASSERT_LE(size, 1000U + 70U) << "and the stretch that is not finished yet";
      ASSERT_GE(size, 330U);
    }
  }
}

class SeriesSize : public ::testing::TestWithParam<std::size_t> {};

TEST_P(SeriesSize, KeepsTheExtremesAtAnyLength) {
  for (std::size_t rows = 1; rows < 3 * GetParam() + 50; ++rows) {
    const std::vector<double> strain = random_walk(rows, static_cast<unsigned>(rows));
    const std::vector<report::PlotPoint> points = filled(strain, GetParam()).points();
    const auto [low, high] = std::ranges::minmax_element(strain);
    const auto has = [&](double value) {
      return std::ranges::find(points, value, &report::PlotPoint::strain_percent) != points.end();
    };
    ASSERT_TRUE(has(*low) && has(*high)) << rows << " rows";
  }
}
INSTANTIATE_TEST_SUITE_P(AnySize, SeriesSize, ::testing::Values(4, 6, 8, 10, 64, 250));

TEST(Series, ASpikeOfOneRowIsSeen) {
  std::vector<double> strain(250'000, 1.0);
  strain[123'457] = 5;
  strain[200'001] = -5;
  const std::vector<report::PlotPoint> points = filled(strain, 4096).points();
  EXPECT_EQ(std::ranges::count(points, 5, &report::PlotPoint::strain_percent), 1);
  EXPECT_EQ(std::ranges::count(points, -5, &report::PlotPoint::strain_percent), 1);
}

// What one series lacks in peaks must not cost those of another one.
TEST(Series, KeepsThePeaksOfAllItsValues) {
  using report::PlotPoint;
  using Both = report::SeriesOf<PlotPoint, &PlotPoint::strain_percent, &PlotPoint::current_A,
                                &PlotPoint::stress_MPa>;
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise;
  for (const std::size_t rows : {50U, 999U, 5000U, 123'456U}) {
    const std::vector<double> strain = random_walk(rows, static_cast<unsigned>(rows));
    std::vector<PlotPoint> all;
    Both series(600);
    for (std::size_t i = 0; i < rows; ++i) {
      PlotPoint p = point(static_cast<double>(i), strain[i]);
      p.current_A = i == rows / 3 ? 50 : noise(random);
      p.stress_MPa = std::numeric_limits<double>::quiet_NaN();
      all.push_back(p);
      series.add(p);
    }
    const std::vector<PlotPoint> kept = series.points();
    EXPECT_LE(kept.size(), 600U + 77U);
    EXPECT_EQ(kept.front().time_s, 0);
    EXPECT_EQ(kept.back().time_s, static_cast<double>(rows - 1));
    for (double PlotPoint::* const value : {&PlotPoint::strain_percent, &PlotPoint::current_A}) {
      const auto [low, high] = std::ranges::minmax_element(all, {}, value);
      EXPECT_EQ(std::ranges::count(kept, low->time_s, &PlotPoint::time_s), 1) << rows;
      EXPECT_EQ(std::ranges::count(kept, high->time_s, &PlotPoint::time_s), 1) << rows;
    }
  }
}

TEST(Series, ALongGapStaysAGap) {
  Series series(500);
  for (int i = 0; i < 100'000; ++i) {
    const bool gap = i >= 40'000 && i < 60'000;
    series.add(point(i, gap ? std::numeric_limits<double>::quiet_NaN() : 1.0));
  }
  EXPECT_TRUE(std::ranges::any_of(series.points(), [](const report::PlotPoint& p) {
    return p.time_s > 45'000 && p.time_s < 55'000 && std::isnan(p.strain_percent);
  }));
}

// A name of a file ends no string of gnuplot's and is no markup.
TEST(Gnuplot, TitlesStayWithinTheirQuotes) {
  EXPECT_EQ(report::plotted_text("step-1"), "'step-1' noenhanced");
  EXPECT_EQ(report::plotted_text("a' ; system 'b\n"), "'a'' ; system ''b\\x0A' noenhanced");
}

}  // namespace

}  // namespace smaservo::test
