#include "host-sim/replay/error_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <random>

namespace smaservo::test {
namespace {

constexpr double rounding = 0.01;

/// The smallest value that this share of all does not exceed.
double sorted_quantile(std::vector<double> sizes, double share) {
  std::ranges::sort(sizes);
  std::size_t rank = 1;
  while (static_cast<double>(rank) < share * static_cast<double>(sizes.size())) {
    ++rank;
  }
  return sizes[rank - 1];
}

TEST(ErrorStatistics, NothingIsZero) {
  const replay::ErrorStatistics none;
  EXPECT_EQ(none.count(), 0U);
  EXPECT_EQ(none.mean(), 0);
  EXPECT_EQ(none.quantile(0.95), 0);
  EXPECT_EQ(none.maximum(), 0);
}

TEST(ErrorStatistics, AgreesWithSorting) {
  std::mt19937_64 random(1);
  for (int run = 0; run < 200; ++run) {
    const int count = std::uniform_int_distribution<int>(1, 3000)(random);
    std::lognormal_distribution<double> size(std::uniform_real_distribution<double>(-4, 3)(random),
                                             1.2);
    replay::ErrorStatistics statistics;
    std::vector<double> sizes;
    for (int i = 0; i < count; ++i) {
      sizes.push_back(size(random));
      statistics.add(i % 2 == 0 ? sizes.back() : -sizes.back());
    }
    ASSERT_EQ(statistics.count(), sizes.size());
    const double mean =
        std::accumulate(sizes.begin(), sizes.end(), 0.0) / static_cast<double>(count);
    ASSERT_NEAR(statistics.mean(), mean, 1e-12 * mean);
    ASSERT_EQ(statistics.maximum(), *std::ranges::max_element(sizes));
    for (const double share : {0.5, 0.9, 0.95, 0.99, 1.0}) {
      const double exact = sorted_quantile(sizes, share);
      ASSERT_GE(statistics.quantile(share), std::min(exact, 1000.0) - 1e-9);
      ASSERT_LE(statistics.quantile(share), exact + rounding + 1e-9);
    }
  }
}

TEST(ErrorStatistics, QuantileIsNeverAboveTheMaximum) {
  replay::ErrorStatistics statistics;
  for (int i = 0; i < 20; ++i) {
    statistics.add(0.003);
  }
  EXPECT_EQ(statistics.quantile(0.95), 0.003);
}

TEST(ErrorStatistics, HugeErrorsNeitherGrowNorVanish) {
  replay::ErrorStatistics statistics;
  for (int i = 0; i < 10; ++i) {
    statistics.add(1e12 * (i + 1));
  }
  EXPECT_EQ(statistics.maximum(), 1e13);
  EXPECT_DOUBLE_EQ(statistics.mean(), 5.5e12);
  EXPECT_GE(statistics.quantile(0.5), 1000);
}

TEST(ErrorStatistics, AnEstimateThatIsNoNumberIsTheGreatestError) {
  replay::ErrorStatistics statistics;
  statistics.add(1);
  statistics.add(std::nan(""));
  EXPECT_EQ(statistics.count(), 2U);
  EXPECT_TRUE(std::isinf(statistics.maximum()));
  EXPECT_FALSE(std::isfinite(statistics.mean()));
}

}  // namespace
}  // namespace smaservo::test
