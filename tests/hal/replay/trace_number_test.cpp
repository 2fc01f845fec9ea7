// Numbers of a trace are what strtod makes of the same text, to the bit.

#include <bit>
#include <cmath>
#include <cstdlib>
#include <gtest/gtest.h>
#include <random>

#include "tests/hal/replay/traces.hpp"

namespace smaservo::test::trace_number_test {
namespace {

using Random = std::mt19937_64;

int between(Random& random, int low, int high) {
  return std::uniform_int_distribution<int>(low, high)(random);
}

std::string digits(Random& random, int count) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    // Zeros and nines are more frequent than by chance, because nines carry when they are rounded.
    const int kind = between(random, 0, 9);
    text += static_cast<char>('0' + (kind == 0 ? 0 : kind == 1 ? 9 : between(random, 0, 9)));
  }
  return text;
}

/// The value by strtod, after a conversion of factor 1, which makes 0 of -0.
double expected(const std::string& text) {
  return std::strtod(text.c_str(), nullptr) + 0.0;
}

/// Reads the texts as a column in pascals, which has the widest range: -1e9 to 1e10.
void expect_same_bits(const std::vector<std::string>& texts) {
  std::string file = "note,stress_Pa,end\n";
  for (const std::string& text : texts) {
    file += "," + text + ",\n";
  }
  const TraceContents t = read_trace(file);
  ASSERT_EQ(t.rows.size(), texts.size());
  for (std::size_t i = 0; i < texts.size(); ++i) {
    ASSERT_EQ(std::bit_cast<std::uint64_t>(t.at(i, hal::Column::stress)),
              std::bit_cast<std::uint64_t>(expected(texts[i])))
        << texts[i] << " is read as " << t.at(i, hal::Column::stress);
  }
}

TEST(TraceNumbers, DecimalsOfAllLengths) {
  Random random(1);
  std::vector<std::string> texts;
  while (texts.size() < 100'000) {
    const int whole = between(random, 0, 9);
    const int decimals = between(random, whole == 0 ? 1 : 0, 26);
    std::string text = between(random, 0, 3) == 0 ? "-" : "";
    text += digits(random, whole);
    text += decimals > 0 ? "." + digits(random, decimals) : std::string();
    texts.push_back(text);
  }
  expect_same_bits(texts);
}

TEST(TraceNumbers, LongTailsOfZerosAndTheFastPathsEdge) {
  Random random(2);
  std::vector<std::string> texts{"0",  "-0",  "0.0", "-0.000000000000000", "9",
                                 "1.", "-1.", ".5",  "999999999.999999",   "999999999.9999999"};
  for (int length = 1; length <= 40; ++length) {
    for (int i = 0; i < 50; ++i) {
      // Leading zeros count as digits for the fast path, and must not change the value.
      texts.push_back(std::string(static_cast<std::size_t>(length), '0') + digits(random, 8));
      texts.push_back("0." + std::string(static_cast<std::size_t>(length), '0') +
                      digits(random, 1 + length));
    }
  }
  expect_same_bits(texts);
}

TEST(TraceNumbers, Exponents) {
  Random random(3);
  std::vector<std::string> texts{"1e9", "1E+9", "1e-9", "1.e0", "-1e-300", "4.9e-324", "1e0009"};
  while (texts.size() < 20'000) {
    std::string text = between(random, 0, 1) == 0 ? "-" : "";
    text += digits(random, between(random, 1, 3)) + "." + digits(random, between(random, 1, 20));
    text += between(random, 0, 1) == 0 ? "e" : "E";
    texts.push_back(text + std::to_string(between(random, -300, 5)));
  }
  expect_same_bits(texts);
}

TEST(TraceNumbers, WrittenAsShortAsPossibleOrInFull) {
  Random random(4);
  std::uniform_real_distribution<double> value(-1e9, 1e9);
  std::vector<std::string> texts;
  for (int i = 0; i < 20'000; ++i) {
    const double scaled = std::ldexp(value(random), -between(random, 0, 60));
    std::array<char, 64> text{};
    const int written = std::snprintf(text.data(), text.size(), "%.17g", scaled);
    texts.emplace_back(text.data(), static_cast<std::size_t>(written));
    ASSERT_EQ(expected(texts.back()), scaled) << "the oracle itself reads what was written";
  }
  expect_same_bits(texts);
}

TEST(TraceNumbers, RangeIsJudgedAfterConversion) {
  Random random(5);
  std::string file = "stress_Pa\n";
  std::vector<double> inside;
  for (int i = 0; i < 20'000; ++i) {
    const std::string text = (between(random, 0, 1) == 0 ? "-" : "") +
                             digits(random, between(random, 1, 16)) + "." + digits(random, 2);
    file += text + "\n";
    if (expected(text) >= -1e9 && expected(text) <= 1e10) {
      inside.push_back(expected(text));
    }
  }
  hal::TraceOptions options;
  options.lenient = true;
  const TraceContents t = read_trace(file, options);
  ASSERT_EQ(t.rows.size(), inside.size());
  ASSERT_GT(t.skipped, 5000U);
  for (std::size_t i = 0; i < inside.size(); ++i) {
    ASSERT_EQ(t.at(i, hal::Column::stress), inside[i]);
  }
}

TEST(TraceNumbers, WhatIsNoPlainNumberIsRefused) {
  for (const char* text : {"",
                           " ",
                           "nan",
                           "NAN",
                           "nan(1)",
                           "inf",
                           "-inf",
                           "infinity",
                           "1e999",
                           "-1e999",
                           "0x10",
                           "0x1p3",
                           "1e",
                           "1e+",
                           "e5",
                           ".",
                           "-",
                           "-.",
                           "--1",
                           "+1",
                           "1 ",
                           " 1",
                           "1;",
                           "1.2.3",
                           "1-2",
                           "1f",
                           "1'000",
                           "1_000",
                           "\"1\"",
                           "\xC2\xB5",
                           "12345678901234567890x",
                           "1234567890123456 "}) {
    const std::string file = std::string("note,current_A,end\nn,") + text + ",e\n";
    const std::string said = refusal(file);
    EXPECT_TRUE(said.starts_with("line 2, column 2 (current_A): ")) << text << ": " << said;
  }
  EXPECT_EQ(refusal("note,current_A\nn,1,5\n"),
            "line 2, column 2 (current_A): the row has 3 columns, the header 2");
}

TEST(TraceNumbers, ANulByteIsNoEndOfNumber) {
  EXPECT_NE(refusal(std::string("current_A\n1\0\n", 13)), "");
}

}  // namespace
}  // namespace smaservo::test::trace_number_test
