#include "host-sim/replay/estimate_file.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::string fixed(double value, int decimals) {
  std::array<char, 64> text{};
  return {text.data(), replay::append_fixed(text.data(), value, decimals)};
}

std::string printed(double value, int decimals) {
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  std::string all = text.data();
  const bool zero = all.find_first_not_of("-0.") == std::string::npos;
  return zero && all.front() == '-' ? all.substr(1) : all;  // an estimate has no -0.000
}

/// Like printf, but for values whose last bits lie below the last decimal's half and round onto the
/// middle of two texts when they are multiplied by a power of ten: either neighbour is right there.
void expect_as_printed(double value, int decimals) {
  const std::string text = fixed(value, decimals);
  if (text == printed(value, decimals)) {
    return;
  }
  const double unit = std::pow(10.0, -decimals);
  ASSERT_GT(std::abs(value), std::ldexp(unit, 40));
  const double off = std::abs(std::strtod(text.c_str(), nullptr) - value);
  ASSERT_EQ(text.size() - text.find('.'),
            printed(value, decimals).size() - printed(value, decimals).find('.'));
  ASSERT_NEAR(off, unit / 2, 4e-16 * std::abs(value)) << text << " for " << printed(value, 17);
}

TEST(AppendFixed, AgreesWithPrintf) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> mantissa(-1, 1);
  for (int i = 0; i < 100'000; ++i) {
    const int decimals = i % 10;
    const double value = std::ldexp(mantissa(random), static_cast<int>(random() % 70) - 50);
    if (std::abs(value) * std::pow(10.0, decimals) < std::ldexp(1.0, 53)) {
      ASSERT_NO_FATAL_FAILURE(expect_as_printed(value, decimals));
    }
  }
}

TEST(AppendFixed, ReadsBackWhatIsADecimalItself) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 100'000; ++i) {
    const int decimals = static_cast<int>(random() % 8);
    const auto units = static_cast<double>(random() % 1'000'000'000'000);
    const double value = units / std::pow(10.0, decimals);
    ASSERT_NO_FATAL_FAILURE(expect_as_printed(value, decimals));
    ASSERT_EQ(std::strtod(fixed(value, decimals).c_str(), nullptr), value);
  }
}

TEST(AppendFixed, WholeNumbersAreExactUpToTheEnd) {
  const double end = std::ldexp(1.0, 53);
  for (double below = 1; below < 1000; ++below) {
    for (const double value : {end - below, end / 2 + below, end / 4 + below, below}) {
      ASSERT_EQ(fixed(value, 0), printed(value, 0));
      ASSERT_EQ(fixed(-value, 0), printed(-value, 0));
    }
  }
}

TEST(AppendFixed, TextsOfEdges) {
  EXPECT_EQ(fixed(nan, 3), "");
  EXPECT_EQ(fixed(-nan, 3), "");
  EXPECT_EQ(fixed(0, 3), "0.000");
  EXPECT_EQ(fixed(-0.0, 3), "0.000");
  EXPECT_EQ(fixed(-0.0004, 3), "0.000");
  EXPECT_EQ(fixed(-0.0006, 3), "-0.001");
  EXPECT_EQ(fixed(0.9996, 3), "1.000");
  EXPECT_EQ(fixed(1e300, 3), "1e+300");
  EXPECT_EQ(std::strtod(fixed(1e17 / 3, 9).c_str(), nullptr), 1e17 / 3);
  EXPECT_EQ(fixed(std::numeric_limits<double>::infinity(), 3), "inf");
}

replay::EstimateRow plain_row() {
  return {.time_s = 1.5,
          .strain = 0.0123456789,
          .strain_sd = 0.001,
          .temperature_K = 300,
          .martensite = 0.25,
          .r_phase = 0.5,
          .resistance_ohm = 24.5,
          .resistance_model_ohm = nan,
          .valid = true,
          .strain_ref = 0.04};
}

constexpr const char* own_header =
    "time_s,strain,strain_sd,wire_temperature_degC,martensite,r_phase,austenite,resistance_ohm,"
    "resistance_model_ohm,valid";

TEST(EstimateFile, HasTheColumnsOfTheFormat) {
  const TemporaryFolder folder;
  replay::EstimateFile file(folder / "e.csv", "t.csv", false, {}, {});
  file.add(plain_row(), "ignored");
  file.commit();
  EXPECT_EQ(file_text(folder / "e.csv"),
            std::string(own_header) +
                "\n1.500000,0.0123457,0.0010000,26.850,0.25000,0.50000,0.25000,24.500000,,1\n");
}

TEST(EstimateFile, WhatIsNotKnownIsEmpty) {
  const TemporaryFolder folder;
  replay::EstimateFile file(folder / "e.csv", "t.csv", true, {}, {});
  file.add({nan, nan, nan, nan, nan, nan, nan, nan, false, nan}, "");
  file.commit();
  EXPECT_EQ(file_text(folder / "e.csv"), std::string(own_header) + ",strain_ref\n,,,,,,,,,0,\n");
}

TEST(EstimateFile, PassesColumnsOnUnderAFreeName) {
  const TemporaryFolder folder;
  replay::EstimateFile file(folder / "e.csv", "t.csv", true,
                            {"note", "strain", "strain_ref", "strain_high"}, {0, 2, 3, 5});
  file.add(plain_row(), "a b,1,,\"x\",4,<&>");
  file.add(plain_row(), ",1,2,,4,");
  file.commit();
  const std::string own =
      "1.500000,0.0123457,0.0010000,26.850,0.25000,0.50000,0.25000,24.500000,,1,"
      "0.0400000,";
  EXPECT_EQ(file_text(folder / "e.csv"),
            std::string(own_header) +
                ",strain_ref,note,trace_strain,trace_strain_ref,strain_high\n" + own +
                "a b,,\"x\",<&>\n" + own + ",2,,\n");
}

TEST(EstimateFile, KeepsItsNameWhereThereIsNoReference) {
  const TemporaryFolder folder;
  replay::EstimateFile file(folder / "e.csv", "t.csv", false, {"strain_ref", "valid"}, {0, 1});
  file.commit();
  EXPECT_EQ(file_text(folder / "e.csv"), std::string(own_header) + ",strain_ref,trace_valid\n");
}

TEST(EstimateFile, TakesRowsOfAnyLengthInAnyOrder) {
  const TemporaryFolder folder;
  std::mt19937_64 random(3);
  std::vector<std::string> notes;
  replay::EstimateFile file(folder / "e.csv", "t.csv", false, {"note"}, {1});
  for (int i = 0; i < 200; ++i) {
    const std::size_t max = i % 20 == 0 ? 700'000 : 5000;
    notes.emplace_back(random() % max, static_cast<char>('a' + i % 26));
    file.add(plain_row(), "7," + notes.back());
  }
  file.commit();
  const std::string text = file_text(folder / "e.csv");
  std::size_t at = text.find('\n') + 1;
  for (const std::string& note : notes) {
    const std::size_t stop = text.find('\n', at);
    const std::size_t comma = text.rfind(',', stop);
    ASSERT_TRUE(text.compare(comma + 1, stop - comma - 1, note) == 0);
    at = stop + 1;
  }
  EXPECT_EQ(at, text.size());
}

}  // namespace
}  // namespace smaservo::test
