#include "firmware/control/profile.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

namespace smaservo::profile_test {
namespace {

constexpr ProfileSettings<double> settings{12, 5, 1.5};

/// The levels in their order, without repetitions.
std::vector<double> levels() {
  std::vector<double> all;
  for (int i = 0; i < 40000; ++i) {
    const double level = Profile<double>::level(settings, i * 1e-3);
    if (all.empty() || all.back() != level) {
      all.push_back(level);
    }
  }
  return all;
}

TEST(Profile, FullCyclesThenLoopsThatShrink) {
  const std::vector<double> all = levels();
  // A cold and a hot level for each cycle, a low and a high one for each loop, and a last cold one.
  ASSERT_EQ(all.size(), 2U * 2U + 10U * 2U + 1U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(all[i], i % 2 == 0 ? 0 : 1);
  }
  for (std::size_t i = 4; i + 3 < all.size(); i += 2) {
    EXPECT_NEAR((all[i] + all[i + 1]) / 2, 0.55, 1e-12);
    EXPECT_LT(all[i + 3] - all[i + 2], 0.9 * (all[i + 1] - all[i]));
    EXPECT_GT(all[i + 3] - all[i + 2], 0.05);
  }
  EXPECT_EQ(all.back(), 0);
}

TEST(Profile, StaysBetweenColdAndHot) {
  const std::vector<double> all = levels();
  EXPECT_EQ(std::ranges::min(all), 0);
  EXPECT_LE(std::ranges::max(all), 1 + 1e-12);
}

TEST(Profile, EndsAndStaysThere) {
  const double end_s = 2 * settings.cycle_s + 10 * settings.loop_s;
  EXPECT_GT(Profile<double>::level(settings, end_s - 1e-3), 0);
  for (const double s : {end_s, end_s + 1, 1e12, std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(Profile<double>::level(settings, s), 0);
  }
}

}  // namespace
}  // namespace smaservo::profile_test
