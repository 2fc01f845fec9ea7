#include "model/files/wire/wire_fields.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <gmock/gmock.h>
#include <set>
#include <sstream>

#include "model/files/text_table.hpp"
#include "model/files/wire/wire_file.hpp"
#include "tests/places.hpp"

namespace smaservo::files {
namespace {

constexpr std::string_view table_begin =
    "<!-- keys: made from wire_fields(), compared in tests -->\n";
constexpr std::string_view table_end = "<!-- end of keys -->\n";

bool is_number(const Field& field) {
  return field.type == FieldType::number || field.type == FieldType::polynomial;
}

std::string units_of(const Field& field) {
  if (!is_number(field)) {
    return "";
  }
  std::vector<std::string> all;
  for (const KeyUnit& unit : key_units(field)) {
    all.push_back(unit.suffix.empty() ? "none" : unit.suffix);
  }
  return fmt::format("{}", fmt::join(all, ", "));
}

std::string range_of(const Field& field) {
  if (field.type == FieldType::choice) {
    return fmt::format("`{}`", fmt::join(field.choices, "`, `"));
  }
  if (field.type == FieldType::flag) {
    return "`true`, `false`";
  }
  const std::string_view suffix = field.kind.front().suffix;
  const std::string range =
      fmt::format("{:.6g} to {:.6g}{}{}", field.min, field.max, suffix.empty() ? "" : " ", suffix);
  return field.type == FieldType::number
             ? range
             : fmt::format("{} (the first of 1 to {} coefficients)", range, field.count);
}

std::string meaning_of(const Field& field) {
  if (field.slot >= wire_parameter_count || is_needed(field) ||
      field.type == FieldType::polynomial) {
    return field.meaning;
  }
  const WireParameter<double>& row = wire_parameters<double>[field.slot];
  const std::string standard =
      !row.follows.empty() ? std::string(row.follows)
      : field.type == FieldType::choice
          ? std::string(row.choices[static_cast<std::size_t>(row.standard)])
          : fmt::format("{}", row.standard);
  return fmt::format("{}; {}", field.meaning, standard);
}

/// Whether the field is a single coefficient of a polynomial; the polynomial is a field of its own.
bool is_coefficient(const Field& field) {
  return field.type == FieldType::number && std::ranges::any_of(wire_fields(), [&](const Field& f) {
           return f.type == FieldType::polynomial && f.slot <= field.slot &&
                  field.slot < f.slot + f.count;
         });
}

std::string key_table() {
  files::TextTable table(
      {{"Key, without its unit"}, {"Units"}, {"Range"}, {"Needed"}, {"Meaning; default"}});
  std::size_t next = 0;
  for (const Field& field : wire_fields()) {
    if (is_coefficient(field)) {
      continue;
    }
    const std::string_view needed = field.slot < next ? "instead" : is_needed(field) ? "yes" : "no";
    next = field.slot + field.count;
    table.add({fmt::format("`{}`", field.path), units_of(field), range_of(field), needed,
               meaning_of(field)});
  }
  return table.markdown();
}

std::string text_of_readme() {
  const std::ifstream in(test::source_folder() + "/model/wires/README.md");
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

TEST(WireFields, NoKeyHasTwoMeanings) {
  std::set<std::string> keys;
  for (const Field& field : wire_fields()) {
    for (const KeyUnit& unit : key_units(field)) {
      EXPECT_TRUE(keys.insert(key_with(field.path, unit.suffix)).second) << field.path;
    }
  }
  EXPECT_GT(keys.size(), wire_fields().size());
}

TEST(WireFields, HaveRangesAndMeanings) {
  for (const Field& field : wire_fields()) {
    EXPECT_NE(field.path.find('.'), std::string::npos) << field.path;
    EXPECT_FALSE(field.kind.empty()) << field.path;
    EXPECT_FALSE(field.meaning.empty()) << field.path;
    if (field.type == FieldType::choice) {
      EXPECT_GE(field.choices.size(), 2U) << field.path;
    } else if (is_number(field)) {
      EXPECT_LT(field.min, field.max) << field.path;
    }
  }
}

TEST(WireFields, OldKeysAreKnown) {
  EXPECT_EQ(renamed_key("limits.current_mA"), "wire.limits.current_mA");
  EXPECT_EQ(renamed_key("kinetics.m2a.start_degC_by_MPa"), "wire.m2a.start_degC_by_MPa");
  EXPECT_EQ(renamed_key("kinetics.memory"), "wire.memory");
  EXPECT_EQ(renamed_key("material.reference_degC"), "wire.material.reference_degC");
  EXPECT_EQ(renamed_key("material.r_phase.strain"), "wire.r_phase.strain");
  EXPECT_EQ(renamed_key("heat"), "wire.heat");
  EXPECT_EQ(renamed_key("accuracy.strain_percent"), "wire.accuracy.strain_percent");
  EXPECT_EQ(renamed_key("measuring.load_gain"), "measurement.load_gain");
  EXPECT_EQ(renamed_key("kalman.loss_walk"), "observer.loss_walk");
  EXPECT_EQ(renamed_key("wire.austenite.resistivity_ohm_m_Pa"),
            "wire.austenite.resistivity_stress_ohm_m_Pa");
  EXPECT_EQ(renamed_key("wire.heat.convection_W_m2K2"), "wire.heat.convection_slope_W_m2K2");
  for (const Field& field : wire_fields()) {
    for (const KeyUnit& unit : key_units(field)) {
      EXPECT_EQ(renamed_key(key_with(field.path, unit.suffix)), "") << field.path;
    }
  }
}

}  // namespace
}  // namespace smaservo::files
