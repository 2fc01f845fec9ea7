#include "host-sim/report/thin.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace smaservo::test {
namespace {

/// A value that is missing.
constexpr double not_there = std::numeric_limits<double>::quiet_NaN();

std::vector<double> noise(std::size_t rows, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> values(rows);
  std::ranges::generate(values, [&] { return normal(random); });
  return values;
}

TEST(Thin, AFewRowsStayAllAndOfNoneNothing) {
  const std::vector<double> values = noise(100, 1);
  const std::vector<const std::vector<double>*> columns{&values};
  EXPECT_EQ(report::rows_to_show(columns, 100).size(), 100U);
  EXPECT_TRUE(report::rows_to_show({}, 100).empty());
  const std::vector<double> nothing;
  const std::vector<const std::vector<double>*> empty{&nothing};
  EXPECT_TRUE(report::rows_to_show(empty, 100).empty());
}

// The bound holds, rows are in order, and the extremes of each quarter are among them.
TEST(Thin, KeepsTheBoundAndThePeaksOfEveryColumn) {
  for (const std::size_t rows : {101U, 1000U, 65'537U, 300'000U}) {
    for (const std::size_t count : {1U, 3U, 8U}) {
      std::vector<std::vector<double>> data;
      data.reserve(count);
      for (std::size_t k = 0; k < count; ++k) {
        data.push_back(noise(rows, static_cast<unsigned>(rows + k)));
      }
      std::vector<const std::vector<double>*> columns;
      columns.reserve(count);
      for (const auto& column : data) {
        columns.push_back(&column);
      }
      const std::vector<std::size_t> kept = report::rows_to_show(columns, 100);
      ASSERT_LE(kept.size(), 100U);
      ASSERT_TRUE(std::ranges::is_sorted(kept, std::less_equal<>{}) ||
                  std::ranges::adjacent_find(kept) == kept.end());
      EXPECT_EQ(kept.front(), 0U);
      EXPECT_EQ(kept.back(), rows - 1);
      for (const auto& column : data) {
        const auto [low, high] = std::ranges::minmax_element(column);
        for (const auto peak : {low, high}) {
          EXPECT_TRUE(
              std::ranges::binary_search(kept, static_cast<std::size_t>(peak - column.begin())));
        }
      }
    }
  }
}

// Curves that stand behind each other with a gap between them do not become one.
TEST(Thin, KeepsAGapOfOneRow) {
  std::vector<double> values = noise(50'000, 7);
  for (std::size_t i = 999; i < values.size(); i += 1000) {
    values[i] = not_there;
  }
  const std::vector<const std::vector<double>*> columns{&values};
  const std::vector<std::size_t> kept = report::rows_to_show(columns, 4000);
  EXPECT_EQ(std::ranges::count_if(kept, [&](std::size_t row) { return std::isnan(values[row]); }),
            50);
}

}  // namespace
}  // namespace smaservo::test
