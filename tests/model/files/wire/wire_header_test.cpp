#include "model/files/wire/wire_header.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <regex>
#include <set>
#include <sstream>

namespace smaservo::files {
namespace {

using ::testing::HasSubstr;

std::string function_of(const std::string& name) {
  WireDescription description = load_wire("smartflex-76um");
  description.name = name;
  const std::string header = to_header(description);
  std::smatch match;
  return std::regex_search(header, match, std::regex(R"(\nsmaservo::Wire<S> (.*)\(\) \{\n)"))
             ? match[1].str()
             : "";
}

// That a header compiles and gives the same wire to the bit is tested by a program outside the
// tree: tests/library.

TEST(WireHeader, TheFunctionHasTheWiresName) {
  EXPECT_EQ(function_of("smartflex-76um"), "wire_smartflex_76um");
  EXPECT_EQ(function_of("unit a"), "wire_unit_a");
  EXPECT_EQ(function_of("76 um"), "wire_76_um");
  EXPECT_EQ(function_of(" -- flexinol (HT)  0.1 mm."), "wire_flexinol_HT_0_1_mm");
  EXPECT_EQ(function_of("__x"), "wire_x");
  EXPECT_EQ(function_of("Ω"), "wire");
  EXPECT_EQ(function_of(""), "wire");
}

/// Whatever stands in a wire file's texts, it stays within a comment's line, and no line goes on in
/// the next one.
TEST(WireHeader, NoTextLeavesItsComment) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 2000; ++i) {
    const auto text = [&] {
      std::string some;
      while (random() % 12 != 0) {
        some += R"(\"/*
 a?)"[random() % 9];
      }
      return some;
    };
    WireDescription description = load_wire("smartflex-76um");
    description.name = text();
    description.sources = {{text(), text()}};
    std::istringstream lines(to_header(description));
    std::string line;
    std::getline(lines, line);
    ASSERT_EQ(line, "#pragma once");
    int comments = 0;
    while (std::getline(lines, line) && !line.empty()) {
      ASSERT_TRUE(line.starts_with("//")) << line;
      ASSERT_FALSE(line.ends_with('\\')) << line;
      ++comments;
    }
    ASSERT_EQ(comments, 2);
    std::getline(lines, line);
    ASSERT_EQ(line, "#include <smaservo/model/wire/wire.hpp>");
  }
}

/// Each number is a floating-point literal, so that no scalar meets an integer that it cannot hold.
TEST(WireHeader, NumbersAreReal) {
  for (const std::string& name : preset_names()) {
    const std::string header = to_header(load_wire(name));
    const std::regex call(R"(S\(([^)]*)\))");
    int numbers = 0;
    for (std::sregex_iterator at(header.begin(), header.end(), call), end; at != end; ++at) {
      EXPECT_THAT((*at)[1].str(), ::testing::ContainsRegex("[.e]"));
      ++numbers;
    }
    EXPECT_GT(numbers, 50);
    EXPECT_THAT(header, HasSubstr(".memory = Memory::return_point"));
  }
}

}  // namespace
}  // namespace smaservo::files
