#include "host-sim/page/servos/history.hpp"

#include <algorithm>
#include <gmock/gmock.h>
#include <random>

namespace smaservo::page {
namespace {

Sample sample_at(std::int64_t time_us,
                 std::initializer_list<std::pair<std::size_t, float>> values) {
  Sample sample;
  sample.time_us = time_us;
  for (const auto& [signal, value] : values) {
    sample.has.set(signal);
    sample.values[signal] = value;
  }
  return sample;
}

TEST(PageHistory, FewRowsComeAsTheyWere) {
  History history;
  history.add(sample_at(1000, {{0, 1.F}, {3, 2.F}}));
  history.add(sample_at(2000, {{5, 7.F}}));
  history.add(sample_at(3000, {{0, 4.F}, {3, 5.F}}));
  const HistoryRows rows = history.last(10'000'000, 100);
  EXPECT_THAT(rows.time_us, testing::ElementsAre(1000, 2000, 3000));
  ASSERT_EQ(rows.columns.size(), 3U);
  EXPECT_EQ(rows.columns[0][0], 1);
  EXPECT_TRUE(std::isnan(rows.columns[0][1]));
  EXPECT_EQ(rows.columns[2][1], 7);
  EXPECT_EQ(history.newest()->values[3], 5);
}

// However few points are asked for, the greatest and least value of each signal are among them, and
// no farther from their times than a part of the span.
TEST(PageHistory, ThinningKeepsEveryPeak) {
  std::mt19937_64 random(7);
  std::normal_distribution<float> noise;
  for (int run = 0; run < 20; ++run) {
    History history;
    const std::int64_t rows = 5000 + static_cast<std::int64_t>(random() % 20'000);
    std::vector<float> all;
    const auto peak_at = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(rows));
    for (std::int64_t i = 0; i < rows; ++i) {
      const float value = i == peak_at ? 100 : noise(random);
      all.push_back(value);
      history.add(sample_at(i * 1000, {{2, value}, {9, -value}}));
    }
    const std::size_t points = 2 + 2 * (random() % 400);
    const HistoryRows thin = history.last(600'000'000, points);
    ASSERT_LE(thin.time_us.size(), points);
    EXPECT_TRUE(std::ranges::is_sorted(thin.time_us));
    const auto greatest = std::ranges::max_element(thin.columns[0]);
    EXPECT_EQ(*greatest, 100);
    EXPECT_EQ(std::ranges::min(thin.columns[1]), -100);
    EXPECT_EQ(std::ranges::min(thin.columns[0]), std::ranges::min(all));
    const std::int64_t time_us =
        thin.time_us[static_cast<std::size_t>(greatest - thin.columns[0].begin())];
    EXPECT_LE(std::abs(time_us - peak_at * 1000),
              2 * rows * 1000 / static_cast<std::int64_t>(points) + 1);
  }
}

TEST(PageHistory, TenMinutesAtFullRateFitAndNoMore) {
  History history;
  SignalSet eight;
  for (std::size_t i = 0; i < 8; ++i) {
    eight.set(i);
  }
  Sample sample;
  sample.has = eight;
  for (std::int64_t i = 0; i < 900'000; ++i) {
    sample.time_us = i * 1000;
    history.add(sample);
    ASSERT_LE(history.bytes(), History::max_bytes + 100'000);
  }
  const HistoryRows rows = history.last(900'000'000, 1'000'000);
  EXPECT_GE(rows.time_us.size(), 600'000U);
  EXPECT_LE(rows.time_us.size(), 602'048U);
  EXPECT_EQ(rows.time_us.back(), 899'999'000);
}

}  // namespace
}  // namespace smaservo::page
