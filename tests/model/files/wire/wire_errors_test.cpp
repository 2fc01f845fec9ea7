// What is wrong with a description is said with its file, key, value and what is allowed.

#include "tests/model/files/wire/wire_errors.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <sstream>

#include "model/files/wire/wire_fields.hpp"

namespace smaservo::files {
namespace {

/// The key of a field in one of its units.
std::string key_of(const Field& field, std::string_view suffix) {
  return key_with(field.path, suffix);
}

/// Whether "table.key = value" is of this field, in any of its units.
bool is_of(const Field& field, std::string_view line) {
  return std::ranges::any_of(key_units(field), [&](const KeyUnit& unit) {
    return line.starts_with(key_of(field, unit.suffix) + " = ");
  });
}

/// A complete description, one line for each field, without the line of `path`.
std::string complete_without(const std::string& path) {
  std::istringstream complete(to_toml(load_wire(std::string(default_wire))));
  std::string text, line, table;
  while (std::getline(complete, line)) {
    if (line.starts_with("[")) {
      table = line.substr(1, line.size() - 2);
    }
    bool dropped = false;
    for (const Field& field : wire_fields()) {
      dropped = dropped || (field.path == path && is_of(field, fmt::format("{}.{}", table, line)));
    }
    text += dropped ? "" : line + "\n";
  }
  return text;
}

class Folder {
 public:
  Folder()
      : path_(std::filesystem::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
    return (path_ / name).string();
  }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

std::string refusal_of_file(const std::string& file) {
  try {
    load_wire(file);
    return {};
  } catch (const ConfigError& error) {
    return error.what();
  }
}

TEST(WireErrors, EveryRequiredKeyIsMissed) {
  ASSERT_EQ(refusal(complete_without("")), "");
  for (const Field* field : written_fields(load_wire(std::string(default_wire)).wire)) {
    const std::string message = refusal(complete_without(field->path));
    if (is_needed(*field)) {
      EXPECT_THAT(message, names({field->path, "missing"}));
    } else {
      EXPECT_EQ(message, "") << field->path;
    }
  }
}

TEST(WireErrors, NameTheFileEvenWhereTheWireHasAName) {
  const std::string unnamed = "[wire]\nlength_m = 0.1\n";
  EXPECT_THAT(refusal(unnamed), names({"my.toml", "wire.diameter", "missing"}));
  EXPECT_THAT(refusal("name = \"gripper\"\n" + unnamed),
              names({"my.toml", "wire.diameter", "missing"}));
  EXPECT_THAT(refusal(own_wire("wire.r2a.start_K_by_Pa = [340]")), names({"my.toml", "wire.r2a"}));
}

TEST(WireErrors, NumbersOutOfRangeInEveryUnit) {
  for (const Field& field : wire_fields()) {
    if (field.type != FieldType::number) {
      continue;
    }
    const double margin = 1e-3 * (field.max - field.min);
    for (const Unit& unit : field.kind) {
      const std::string key = key_of(field, unit.suffix);
      for (const double outside : {field.min - margin, field.max + margin}) {
        const std::string value = fmt::format("{}", unit.from_si(outside));
        EXPECT_THAT(refusal(own_wire(key + " = " + value)),
                    names({"my.toml:2", key, "must be between",
                           fmt::format("{:.6g} and {:.6g}", unit.from_si(field.min),
                                       unit.from_si(field.max)),
                           fmt::format("is {:.6g}", unit.from_si(outside))}));
      }
      for (const double inside : {field.min + margin, field.max - margin}) {
        const std::string line = fmt::format("{} = {}", key, unit.from_si(inside));
        EXPECT_THAT(refusal(own_wire(line)),
                    testing::Not(testing::ContainsRegex(key + " = [^:]*: must be between")));
      }
    }
  }
}

TEST(WireErrors, PolynomialsOutOfRangeAtZeroStress) {
  for (const Field& field : wire_fields()) {
    if (field.type != FieldType::polynomial) {
      continue;
    }
    const double margin = 1e-3 * (field.max - field.min);
    for (const KeyUnit& unit : key_units(field)) {
      const std::string key = key_of(field, unit.suffix);
      for (const double outside : {field.min - margin, field.max + margin}) {
        EXPECT_THAT(refusal(own_wire(fmt::format("{} = [{}]", key, unit.value.from_si(outside)))),
                    names({"my.toml:2", key, "at zero stress must be between",
                           fmt::format("is {:.6g}", unit.value.from_si(outside))}));
      }
    }
  }
}

TEST(WireErrors, NumbersThatAreNoFiniteNumbers) {
  for (const Field& field : wire_fields()) {
    if (field.type == FieldType::choice || field.type == FieldType::flag) {
      continue;
    }
    const std::string key = key_of(field, key_units(field).front().suffix);
    const bool list = field.type == FieldType::polynomial;
    for (const std::string bad : {"nan", "inf", "-inf", "\"5\"", "true", "1979-05-27"}) {
      const std::string value = list ? "[" + bad + "]" : bad;
      EXPECT_THAT(refusal(own_wire(key + " = " + value)),
                  names({"my.toml:2", key, "must be a finite number"}));
    }
    if (list) {
      EXPECT_THAT(refusal(own_wire(key + " = [300, nan]")), names({key, "finite"}));
      for (const std::string bad : {"300", "[]", "\"300\"", "[1, 2, 3, 4]"}) {
        EXPECT_THAT(refusal(own_wire(key + " = " + bad)),
                    names({"my.toml:2", key, fmt::format("1 to {} coeff", field.count)}));
      }
    } else {
      EXPECT_THAT(refusal(own_wire(key + " = [1.0]")), names({"my.toml:2", key, "finite number"}));
    }
  }
}

TEST(WireErrors, UnknownKeysUnitsAndTables) {
  EXPECT_THAT(refusal(own_wire("wire.colour = 3")),
              names({"my.toml:2", "wire.colour = 3", "unknown key", "length", "diameter"}));
  EXPECT_THAT(refusal(own_wire("wire.length_cm = 3")),
              names({"my.toml:2", "wire.length_cm = 3", "unit", "length_m", "length_mm"}));
  EXPECT_THAT(refusal(own_wire("wire.length = 3")), names({"wire.length = 3", "length_mm"}));
  EXPECT_THAT(refusal(own_wire("wire.m2a.start_degC = 70")),
              names({"wire.m2a.start_degC = 70", "start_degC_by_MPa"}));
  EXPECT_THAT(refusal(own_wire("weather.rain = 1")),
              names({"my.toml:2", "weather.rain = 1", "unknown table"}));
  EXPECT_THAT(refusal(own_wire("length_m = 1")), names({"my.toml:2", "length_m = 1", "unknown"}));
  EXPECT_THAT(refusal(own_wire("wire = 1")), names({"my.toml:2", "wire = 1", "unknown"}));
  EXPECT_THAT(refusal(own_wire("wire.heat.density_kg_m3.x = 1")),
              names({"wire.heat.density_kg_m3.x = 1", "unknown"}));
}

TEST(WireErrors, OldKeysSayWhatTheyAreCalledNow) {
  EXPECT_EQ(refusal(own_wire("[limits]\ncurrent_mA = 92")),
            "my.toml:3: limits.current_mA = 92: is now called wire.limits.current_mA");
  EXPECT_EQ(refusal(own_wire("kinetics.m2a.start_degC_by_MPa = [70]")),
            "my.toml:2: kinetics.m2a.start_degC_by_MPa = [ 70 ]: is now called "
            "wire.m2a.start_degC_by_MPa");
  EXPECT_EQ(refusal(own_wire(""), {{"limits.current_mA", "92"}}),
            "--set: limits.current_mA = 92: is now called wire.limits.current_mA");
  EXPECT_EQ(refusal(own_wire(""), {{"kinetics.memory", "plain"}}),
            "--set: kinetics.memory = 'plain': is now called wire.memory");
  EXPECT_EQ(refusal(own_wire("wire.r_phase.resistivity_ohm_m_K = 1e-9")),
            "my.toml:2: wire.r_phase.resistivity_ohm_m_K = 1e-09: is now called "
            "wire.r_phase.resistivity_temperature_ohm_m_K");
  EXPECT_THAT(refusal(own_wire("sources.\"kinetics.m2a\" = \"a fit\"")),
              names({"my.toml:2", "kinetics.m2a is now called wire.m2a"}));
  EXPECT_THAT(refusal(own_wire("limits.colour = 3")), names({"limits.colour", "unknown table"}));
}

TEST(WireErrors, ANumberGivenTwiceInTwoWays) {
  for (const char* lines : {"wire.limits.load_N = 2\nwire.limits.stress_MPa = 400",
                            "wire.m2a.start_degC_by_MPa = [70]\nwire.m2a.start_1_K_MPa = 0.1",
                            "wire.austenite.resistivity_temperature_1_K = 2e-4\n"
                            "wire.austenite.resistivity_temperature_ohm_m_K = 2e-10"}) {
    EXPECT_THAT(refusal(own_wire(lines)), names({"my.toml:2", "my.toml:3", "given twice"}))
        << lines;
  }
}

TEST(WireErrors, AKeyGivenTwiceInTwoUnits) {
  EXPECT_THAT(refusal(own_wire("wire.length_m = 0.1\nwire.length_mm = 100")),
              names({"my.toml:2", "my.toml:3", "wire.length_m = 0.1", "wire.length_mm = 100",
                     "given twice"}));
  EXPECT_THAT(refusal(own_wire("wire.a2r.start_K_by_Pa = [330]\n"
                               "wire.a2r.start_degC_by_MPa = [57]")),
              names({"wire.a2r.start_K_by_Pa", "wire.a2r.start_degC_by_MPa", "twice"}));
}

TEST(WireErrors, ChoicesNameWhatMayStand) {
  EXPECT_THAT(refusal(own_wire("wire.memory = \"perfect\"")),
              names({"my.toml:2", "wire.memory", "perfect", "return-point", "plain"}));
  EXPECT_THAT(refusal(own_wire("wire.material.mixture = 3")),
              names({"my.toml:2", "wire.material.mixture = 3", "series", "parallel"}));
}

TEST(WireErrors, TransformationsThatRunBackwards) {
  EXPECT_THAT(refusal(own_wire("wire.m2a.finish_degC_by_MPa = [60]")),
              names({"my.toml", "wire.m2a", "finish must be at least 1 K above start"}));
  EXPECT_THAT(refusal(own_wire("wire.a2r.finish_degC_by_MPa = [61.5]")),
              names({"my.toml", "wire.a2r", "below start", "0.5 K"}));
  // This transition is valid at zero stress, but not at the greatest stress that the wire may
  // carry.
  EXPECT_THAT(refusal(own_wire("wire.m2a.finish_degC_by_MPa = [77.5, 0.1]")),
              names({"my.toml", "wire.m2a", "above start", "MPa"}));
  EXPECT_THAT(refusal(own_wire("wire.m2a.curvature_by_MPa = [4, -0.01]")),
              names({"my.toml", "wire.m2a.curvature", "0.001 and 30", "MPa"}));
  EXPECT_THAT(refusal(own_wire("wire.a2m.turning_by_MPa = [0.43, 0.002]")),
              names({"my.toml", "wire.a2m.turning", "0.05 and 0.95", "MPa"}));
}

TEST(WireErrors, AnInfiniteTemperatureUnderLoadIsRefused) {
  EXPECT_THAT(refusal(own_wire("wire.a2r.start_degC_by_MPa = [62, 0, 1e307]")),
              names({"wire.a2r"}));
}

TEST(WireErrors, SeparateProcessesNeedAllFourParts) {
  const std::string parts[] = {
      "wire.r2a.start_degC_by_MPa = [70, 0.125]", "wire.r2a.finish_degC_by_MPa = [76, 0.14]",
      "wire.r2a.curvature_by_MPa = [3]", "wire.r2a.turning_by_MPa = [0.5]"};
  for (unsigned given = 1; given < 16; ++given) {
    std::string lines;
    for (unsigned i = 0; i < 4; ++i) {
      lines += (given >> i & 1U) != 0 ? parts[i] + "\n" : "";
    }
    if (given < 15) {
      EXPECT_THAT(refusal(own_wire(lines)),
                  names({"wire.r2a", "start, finish, curvature and turning"}));
    } else {
      const auto k = parse_wire(own_wire(lines), "my.toml").wire.kinetics;
      EXPECT_TRUE(k.separate_r2a);
      EXPECT_FALSE(k.separate_r2m);
      EXPECT_NEAR(k.r2a.start_K[0], 343.15, 1e-9);
    }
  }
}

TEST(WireErrors, ACycleMustNotGainHeat) {
  EXPECT_THAT(refusal(own_wire("wire.heat.latent_r2a_kJ_kg = 21")),
              names({"my.toml:2", "wire.heat.latent_r2a_kJ_kg = 21", "latent_m2a"}));
}

TEST(WireErrors, NamesAndSourcesMustBeStrings) {
  EXPECT_THAT(refusal(own_wire("name = 3")), names({"my.toml:2", "name = 3", "must be a string"}));
  EXPECT_THAT(refusal("based_on = 3"),
              names({"my.toml:1", "based_on = 3", "preset or a wire file"}));
  EXPECT_THAT(refusal(own_wire("sources.\"wire.length\" = 3")),
              names({"my.toml:2", "wire.length = 3", "must be a string"}));
  EXPECT_THAT(refusal(own_wire("sources = 3")), names({"my.toml:2", "sources = 3"}));
}

// Only presets can be chosen by size, so sizes in another file would never be used.
TEST(WireErrors, SizesOfAnOwnFileAreNotPassedOverInSilence) {
  EXPECT_THAT(refusal(own_wire("sizes.thin.wire.diameter_um = 20")), names({"my.toml", "sizes"}));
}

TEST(WireErrors, FilesThatAreNotThereOrNoToml) {
  const Folder folder;
  EXPECT_THAT(refusal_of_file(folder.file("none.toml")), names({"none.toml", "cannot be read"}));
  const std::string broken = folder.write("broken.toml", "[wire]\nlength_m = = 3\n");
  EXPECT_THAT(refusal_of_file(broken), names({"broken.toml:2:"}));
  const std::string orphan = folder.write("orphan.toml", "based_on = \"none.toml\"\n");
  EXPECT_THAT(refusal_of_file(orphan), names({"none.toml", "cannot be read"}));
  EXPECT_THAT(refusal_of_file("smartflex-77um"),
              names({"smartflex-77um", "smartflex-76um", ".toml"}));
  EXPECT_THAT(refusal_of_file("smartflex"), names({"smartflex-76um"}));
  EXPECT_THAT(refusal_of_file(""), names({"smartflex-76um"}));
}

TEST(WireErrors, CircularBasesEnd) {
  const Folder folder;
  const std::string a = folder.write("a.toml", "based_on = \"b.toml\"\n");
  folder.write("b.toml", "based_on = \"a.toml\"\n");
  EXPECT_THAT(refusal_of_file(a), names({".toml:1: based_on = ", "circle"}));
  const std::string self = folder.write("self.toml", "based_on = \"self.toml\"\n");
  EXPECT_THAT(refusal_of_file(self), names({"self.toml", "circle"}));
}

TEST(WireErrors, BasesAreLookedForBesideTheirFile) {
  const Folder folder;
  folder.write("base.toml", own_wire("name = \"base\"\nwire.length_m = 0.2"));
  const std::string top =
      folder.write("top.toml", "based_on = \"base.toml\"\nname = \"top\"\nwire.diameter_um = 80\n");
  const WireDescription top_wire = load_wire(top);
  EXPECT_EQ(top_wire.name, "top");
  EXPECT_EQ(top_wire.wire.geometry.length_m, 0.2);
  EXPECT_NEAR(top_wire.wire.geometry.diameter_m, 80e-6, 1e-15);
}

}  // namespace
}  // namespace smaservo::files
