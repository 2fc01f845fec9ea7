// What a lenient reader makes of times that do not rise: one bad time costs one row, wherever it is
// and whatever it says; no row is lost where a counter wraps or a clock begins anew.

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <set>

#include "tests/hal/replay/traces.hpp"

namespace smaservo::test::time_repair_test {
namespace {

using ::testing::HasSubstr;

struct Reading {
  TraceContents contents;
  std::vector<std::uint32_t> pieces;
  std::vector<std::uint64_t> numbers;
  std::vector<std::string> clock_notes;
};

Reading read_leniently(const std::string& text) {
  const TemporaryFolder folder;
  hal::TraceOptions options;
  options.lenient = true;
  hal::TraceReader reader(folder.write("t.csv", text), options);
  Reading all;
  hal::TraceRow row{};
  while (reader.next(row)) {
    all.contents.rows.push_back(row.values);
    all.contents.texts.emplace_back(row.text);
    all.pieces.push_back(row.piece);
    all.numbers.push_back(row.number);
  }
  all.contents.skipped = reader.skipped();
  all.contents.complaints = reader.complaints();
  all.clock_notes = reader.clock_notes();
  return all;
}

std::string table(const std::string& name, const std::vector<double>& times) {
  std::string text = name + ",row\n";
  for (std::size_t i = 0; i < times.size(); ++i) {
    text += fmt::format("{},{}\n", times[i], i);
  }
  return text;
}

/// Rising times with some jitter.
std::vector<double> rising(std::mt19937_64& random, std::size_t rows, double from_s,
                           double step_s) {
  std::uniform_real_distribution<double> jitter(0.5, 1.5);
  std::vector<double> all;
  for (double time_s = from_s; all.size() < rows; time_s += step_s * jitter(random)) {
    all.push_back(time_s);
  }
  return all;
}

void expect_rising(const Reading& reading) {
  for (std::size_t i = 1; i < reading.contents.rows.size(); ++i) {
    ASSERT_GT(reading.contents.at(i, hal::Column::time),
              reading.contents.at(i - 1, hal::Column::time));
    ASSERT_GT(reading.numbers[i], reading.numbers[i - 1]);
  }
}

TEST(TimeRepair, EachBadTimeCostsItsRowAndNoOther) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 200; ++round) {
    std::vector<double> times = rising(random, 60, 100, 0.1);
    const std::vector<double> good = times;
    std::set<std::size_t> bad;
    for (std::size_t i = 1 + random() % 4; i + 3 < times.size(); i += 4 + random() % 12) {
      // Errors ahead (up to a flipped bit of the time) or behind, within the trace's times or
      // beyond them.
      const double off[] = {3e6, 1, -1, -50, -99.9};
      times[i] += off[random() % std::size(off)];
      bad.insert(i);
    }
    const Reading r = read_leniently(table("time_s", times));
    EXPECT_EQ(r.contents.skipped, bad.size());
    EXPECT_TRUE(r.clock_notes.empty());
    expect_rising(r);
    std::size_t at = 0;
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (!bad.contains(i)) {
        ASSERT_EQ(r.numbers.at(at), i);
        ASSERT_EQ(r.contents.at(at, hal::Column::time), good[i]);
        ASSERT_EQ(r.pieces[at], 0U);
        ++at;
      }
    }
    EXPECT_EQ(at, r.contents.rows.size());
  }
}

TEST(TimeRepair, AClockThatBeganAnewLosesNothing) {
  std::mt19937_64 random(2);
  for (int round = 0; round < 100; ++round) {
    std::vector<double> times;
    std::vector<std::size_t> begins;
    for (int piece = 0; piece < 3; ++piece) {
      const std::vector<double> part = rising(random, 10 + random() % 20, 0.05 * piece, 0.1);
      begins.push_back(times.size());
      times.insert(times.end(), part.begin(), part.end());
    }
    const Reading r = read_leniently(table("time_s", times));
    EXPECT_EQ(r.contents.skipped, 0U);
    ASSERT_EQ(r.contents.rows.size(), times.size());
    EXPECT_EQ(r.clock_notes.size(), 2U);
    expect_rising(r);
    for (std::size_t i = 0; i < times.size(); ++i) {
      const auto piece = std::ranges::upper_bound(begins, i) - begins.begin() - 1;
      ASSERT_EQ(r.pieces[i], piece);
      if (i > 0 && r.pieces[i] == r.pieces[i - 1]) {
        ASSERT_NEAR(r.contents.at(i, hal::Column::time) - r.contents.at(i - 1, hal::Column::time),
                    times[i] - times[i - 1], 1e-9);
      }
    }
  }
}

TEST(TimeRepair, ACounterThatWrapsGoesOn) {
  std::mt19937_64 random(3);
  const std::vector<double> true_us = rising(random, 400, 4294.9e6, 1e4);
  std::vector<double> wrapped;
  wrapped.reserve(true_us.size());
  for (const double us : true_us) {
    wrapped.push_back(std::fmod(std::round(us), 4294967296.0));
  }
  const Reading r = read_leniently(table("time_us", wrapped));
  EXPECT_EQ(r.contents.skipped, 0U);
  ASSERT_EQ(r.clock_notes.size(), 1U);
  EXPECT_THAT(r.clock_notes[0], HasSubstr("a counter that began at 0 again goes on"));
  ASSERT_EQ(r.contents.rows.size(), true_us.size());
  for (std::size_t i = 0; i < true_us.size(); ++i) {
    EXPECT_NEAR(r.contents.at(i, hal::Column::time), 1e-6 * std::round(true_us[i]), 1e-9);
    EXPECT_EQ(r.pieces[i], 0U);
  }
}

TEST(TimeRepair, MoreThanHalfLostIsAnError) {
  hal::TraceOptions options;
  options.lenient = true;
  EXPECT_EQ(refusal("time_s,current_A\n0,1\nx,1\ny,1\n", options),
            "2 of 3 rows are bad, more than half; line 3, column 1 (time_s): 'x' is not a finite "
            "number");
  EXPECT_EQ(refusal("time_s,current_A\n0,1\nx,1\n", options), "") << "just half";
}

}  // namespace
}  // namespace smaservo::test::time_repair_test
