#include "model/files/wire_fields.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <gmock/gmock.h>
#include <set>
#include <sstream>

#include "model/files/wire_file.hpp"

namespace smaservo {
namespace {

constexpr std::string_view table_begin =
    "<!-- keys: made from wire_fields(), compared in tests -->\n";
constexpr std::string_view table_end = "<!-- end of keys -->\n";

std::string units_of(const WireField& field) {
  std::vector<std::string> all;
  if (field.type == WireFieldType::polynomial) {
    for (const PolynomialUnit& unit : polynomial_units(field)) {
      all.push_back(unit.suffix);
    }
  } else {
    for (const Unit& unit : field.kind) {
      all.emplace_back(unit.suffix.empty() ? "none" : unit.suffix);
    }
  }
  return fmt::format("{}", fmt::join(all, ", "));
}

std::string range_of(const WireField& field) {
  if (field.type == WireFieldType::choice) {
    return fmt::format("`{}`", fmt::join(field.choices, "`, `"));
  }
  const std::string_view suffix = field.kind.front().suffix;
  const std::string range =
      fmt::format("{:.6g} to {:.6g}{}{}", field.low, field.high, suffix.empty() ? "" : " ", suffix);
  return field.type == WireFieldType::number
             ? range
             : fmt::format("{}; {} coefficients", range, field.coefficients);
}

std::string key_table() {
  std::string table =
      "| Key, without its unit | Units | Range | Needed | Meaning; default "
      "|\n|---|---|---|---|---|\n";
  for (const WireField& field : wire_fields()) {
    table += fmt::format("| `{}` | {} | {} | {} | {} |\n", field.path, units_of(field),
                         range_of(field), field.required ? "yes" : "no", field.meaning);
  }
  return table;
}

std::string text_of_readme() {
  const std::ifstream in(SMASERVO_SOURCE_DIR "/model/wires/README.md");
  std::ostringstream content;
  content << in.rdbuf();
  return content.str();
}

TEST(WireFields, ReadmeListsThem) {
  const std::string readme = text_of_readme();
  const std::size_t begin = readme.find(table_begin);
  const std::size_t end = readme.find(table_end);
  ASSERT_NE(begin, std::string::npos) << "model/wires/README.md lacks " << table_begin;
  ASSERT_NE(end, std::string::npos) << "model/wires/README.md lacks " << table_end;
  ASSERT_LT(begin, end);
  const std::size_t from = begin + table_begin.size();
  EXPECT_EQ(readme.substr(from, end - from), key_table())
      << "model/wires/README.md is stale; between its two markers must stand:\n"
      << key_table();
}

TEST(WireFields, ReadmeExampleLoadsAndItsErrorIsReal) {
  const std::string readme = text_of_readme();
  const std::string fence = "```toml\n";
  const std::size_t begin = readme.find(fence) + fence.size();
  const std::string example = readme.substr(begin, readme.find("```", begin) - begin);
  const WireDescription gripper = parse_wire(example, "gripper.toml");
  EXPECT_EQ(gripper.name, "gripper");
  EXPECT_NEAR(gripper.wire.geometry.length_m, 0.182, 1e-12);
  EXPECT_NEAR(gripper.wire.kinetics.m2a.start_K[0], 342.65, 1e-9);

  std::string broken = example;
  broken.replace(broken.find("length_mm = 182"), 15, "length_mm = 200000");
  try {
    parse_wire(broken, "gripper.toml");
    FAIL() << "a wire of 200 m is accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(readme, testing::HasSubstr("    " + std::string(error.what()) + "\n"));
  }
}

TEST(WireFields, PathsAreUniqueAndNoKeyHasTwoMeanings) {
  std::set<std::string> keys;
  for (const WireField& field : wire_fields()) {
    if (field.type == WireFieldType::choice) {
      EXPECT_TRUE(keys.insert(field.path).second) << field.path;
    } else if (field.type == WireFieldType::polynomial) {
      for (const PolynomialUnit& unit : polynomial_units(field)) {
        EXPECT_TRUE(keys.insert(field.path + "_" + unit.suffix).second) << field.path;
      }
    } else {
      for (const Unit& unit : field.kind) {
        const std::string tail = unit.suffix.empty() ? "" : "_" + std::string(unit.suffix);
        EXPECT_TRUE(keys.insert(field.path + tail).second) << field.path;
      }
    }
  }
  EXPECT_GT(keys.size(), wire_fields().size());
}

TEST(WireFields, HaveRangesAndMeanings) {
  for (const WireField& field : wire_fields()) {
    EXPECT_NE(field.path.find('.'), std::string::npos) << field.path;
    if (field.type == WireFieldType::choice) {
      EXPECT_GE(field.choices.size(), 2U) << field.path;
    } else {
      EXPECT_LT(field.low, field.high) << field.path;
      EXPECT_FALSE(field.kind.empty()) << field.path;
    }
  }
}

}  // namespace
}  // namespace smaservo
