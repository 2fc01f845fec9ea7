#include "host-sim/report/series.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

#include "host-sim/report/gnuplot.hpp"

namespace smaservo::test {
namespace {

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

report::Series filled(const std::vector<double>& strain, std::size_t max) {
  report::Series series(max);
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
  EXPECT_TRUE(report::Series().points().empty());
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
  report::Series series(1000);
  for (std::size_t i = 0; i < strain.size(); ++i) {
    series.add(point(static_cast<double>(i), strain[i]));
    if (i % 1009 == 0 && i > 2000) {
      const std::size_t size = series.points().size();
      ASSERT_LE(size, 1002U);
      ASSERT_GE(size, 450U);
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

// A name of a file ends no string of gnuplot's and is no markup.
TEST(Gnuplot, TitlesStayWithinTheirQuotes) {
  EXPECT_EQ(report::plotted_text("step-1"), "'step-1' noenhanced");
  EXPECT_EQ(report::plotted_text("a' ; system 'b\n"), "'a'' ; system ''b\\x0A' noenhanced");
}

}  // namespace

}  // namespace smaservo::test
