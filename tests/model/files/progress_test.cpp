#include "model/files/progress.hpp"

#include <gtest/gtest.h>
#include <random>

namespace smaservo::files {
namespace {

TEST(Duration, IsSaidAsPeopleSayIt) {
  EXPECT_EQ(duration_text(0), "0 s");
  EXPECT_EQ(duration_text(44.6), "45 s");
  EXPECT_EQ(duration_text(99), "99 s");
  EXPECT_EQ(duration_text(100), "2 min");
  EXPECT_EQ(duration_text(12 * 60 + 20), "12 min");
  EXPECT_EQ(duration_text(3600 + 5 * 60), "65 min");
  EXPECT_EQ(duration_text(2 * 3600 + 5 * 60 + 10), "2 h 05 min");
}

TEST(Progress, ALogOfADayHasSomeHundredLines) {
  using namespace std::chrono_literals;
  EXPECT_EQ(pause_in_a_log(0ms), 10s);
  EXPECT_EQ(pause_in_a_log(5min), 10s);
  EXPECT_EQ(pause_in_a_log(1h), 2min);
  int lines = 0;
  for (std::chrono::milliseconds now = 10s; now < 24h; now += pause_in_a_log(now)) {
    ++lines;
  }
  EXPECT_GT(lines, 100);
  EXPECT_LT(lines, 300);
}

TEST(Forecast, SaysNoTimeWhileNothingIsDone) {
  Forecast forecast;
  EXPECT_EQ(forecast.text("fit", 0, 12), "fit: 12 s so far");
  EXPECT_EQ(forecast.text("fit", std::nan(""), 12), "fit: 12 s so far");
}

TEST(Forecast, FallsWhileALargePartGoesOn) {
  Forecast forecast;
  EXPECT_EQ(forecast.text("runs", 0.25, 20), "runs: 25 %, 60 s left");
  EXPECT_EQ(forecast.text("runs", 0.25, 50), "runs: 25 %, 30 s left");
  EXPECT_EQ(forecast.text("runs", 0.25, 200), "runs: 25 %, longer than expected");
  EXPECT_EQ(forecast.text("runs", 0.5, 200), "runs: 50 %, 3 min left");
}

/// Work that goes on evenly: the forecast is right at every moment, whatever the parts.
TEST(Forecast, IsRightWhereTheWorkIsEven) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937_64 random(seed);
    const int parts = std::uniform_int_distribution<int>(1, 200)(random);
    const double whole_s = std::uniform_real_distribution<double>(20, 90)(random);
    Forecast forecast;
    for (int done = 1; done <= parts; ++done) {
      const double at_s = whole_s * done / parts;
      const std::string text = forecast.text("runs", static_cast<double>(done) / parts, at_s);
      EXPECT_TRUE(text.ends_with(", " + duration_text(whole_s - at_s) + " left"))
          << text << " at " << at_s << " of " << whole_s;
    }
  }
}

}  // namespace
}  // namespace smaservo::files
