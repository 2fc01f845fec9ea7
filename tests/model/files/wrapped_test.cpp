#include "model/files/wrapped.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <random>

namespace smaservo::test {
namespace {

std::string random_text(std::mt19937_64& random) {
  std::uniform_int_distribution<std::size_t> length(1, 30);
  std::string text;
  for (std::size_t words = length(random); words > 0; --words) {
    const std::string letter = words % 5 == 0 ? "µ" : "x";
    for (std::size_t i = length(random); i > 0; --i) {
      text += letter;
    }
    text += words > 1 ? " " : "";
  }
  return text;
}

TEST(Broken, KeepsEveryWordInOrderAndNoLineIsLongerThanItMustBe) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const std::string text = random_text(random);
    const std::size_t width = 5 + random() % 60;
    const std::vector<std::string> lines = files::broken(text, width);
    EXPECT_EQ(fmt::format("{}", fmt::join(lines, " ")), text);
    for (std::size_t k = 0; k < lines.size(); ++k) {
      EXPECT_TRUE(files::width_of(lines[k]) <= width || lines[k].find(' ') == std::string::npos);
      if (k > 0) {
        const std::string first = lines[k].substr(0, lines[k].find(' '));
        EXPECT_GT(files::width_of(lines[k - 1]) + 1 + files::width_of(first), width);
      }
    }
  }
  EXPECT_EQ(files::broken("", 10), std::vector<std::string>{""});
}

TEST(Paragraph, StandsBesideItsHeading) {
  const std::string text(100, 'a');
  EXPECT_EQ(files::paragraph("rate", "10 rows/s", 12), "rate        10 rows/s\n");
  EXPECT_EQ(files::paragraph("x", text + " " + text, 4), "x   " + text + "\n    " + text + "\n");
}

TEST(WrappedHelp, BreaksDescriptionsOnly) {
  const std::string word(20, 'w');
  const std::string help =
      "Does it.\nUsage: it\n\nOptions:\n  --short                     a word\n"
      "  --long TEXT                 " +
      word + " " + word + " " + word + "\n";
  EXPECT_EQ(files::wrapped_help(help),
            "Does it.\nUsage: it\n\nOptions:\n  --short                     a word\n"
            "  --long TEXT                 " +
                word + " " + word + "\n" + std::string(30, ' ') + word + "\n");
  EXPECT_EQ(files::wrapped_help(""), "");
  EXPECT_EQ(files::wrapped_help("one line"), "one line");
  // An option with many choices.
  const std::string choices(38, 'u');
  EXPECT_EQ(files::wrapped_help("  --row TEXT:{" + choices + "," + choices + "}\n"),
            "  --row TEXT:{" + choices + ",\n      " + choices + "}\n");
}

}  // namespace
}  // namespace smaservo::test
