// firmware/SAFETY.md names tests and faults; none of them may be one that is not there, and no
// fault may be left out.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "firmware/safety/faults/table.hpp"
#include "tests/places.hpp"

namespace smaservo::safety_table_test {
namespace {

const std::filesystem::path root = test::source_folder();

std::string content(const std::filesystem::path& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// What stands in backticks in the rows of the table.
std::set<std::string> named() {
  static const std::regex quoted("`([^`]+)`");
  std::set<std::string> names;
  std::istringstream lines(content(root / "firmware/SAFETY.md"));
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| ")) {
      continue;
    }
    for (std::sregex_iterator m(line.begin(), line.end(), quoted), end; m != end; ++m) {
      names.insert((*m)[1].str());
    }
  }
  return names;
}

/// Every test of GoogleTest in the tree, as Suite.Name.
std::set<std::string> tests() {
  static const std::regex test(R"(\bTEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\s*\))");
  std::set<std::string> all;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root / "tests")) {
    if (entry.path().extension() != ".cpp") {
      continue;
    }
    const std::string text = content(entry.path());
    for (std::sregex_iterator m(text.begin(), text.end(), test), end; m != end; ++m) {
      all.insert((*m)[1].str() + "." + (*m)[2].str());
    }
  }
  return all;
}

TEST(SafetyTable, EveryTestThatItNamesExists) {
  static const std::regex test(R"([A-Z]\w*\.[A-Z]\w*)");
  const std::set<std::string> all = tests();
  ASSERT_LT(500U, all.size());
  int checked = 0;
  for (const std::string& name : named()) {
    if (std::regex_match(name, test)) {
      EXPECT_TRUE(all.contains(name)) << name << " is no test";
      ++checked;
    } else if (std::regex_match(name, std::regex("[a-z]+(_[a-z]+)*"))) {
      const bool is_fault =
          std::ranges::any_of(fault_rows, [&](const FaultRow& row) { return row.name == name; });
      const bool is_check = std::filesystem::exists(root / "tests/board" / (name + ".sh"));
      EXPECT_TRUE(is_fault || is_check) << name << " is neither a fault nor a check of the board";
    }
  }
  EXPECT_LT(30, checked);
}

TEST(SafetyTable, EveryFaultStandsInIt) {
  const std::set<std::string> names = named();
  for (const FaultRow& row : fault_rows) {
    EXPECT_TRUE(names.contains(std::string(row.name))) << row.name << " guards against nothing";
  }
}

}  // namespace
}  // namespace smaservo::safety_table_test
