#include "model/papers/actuators/actuator_file.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gmock/gmock.h>
#include <sstream>
#include <string>
#include <vector>

#include "model/files/error.hpp"

namespace smaservo::papers {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string preset_text() {
  for (const ActuatorPreset& preset : actuator_presets()) {
    if (preset.name == paper_001_actuator) {
      return std::string(preset.text);
    }
  }
  return {};
}

/// What a description is refused with; empty where it is accepted.
std::string refusal(const std::string& text) {
  try {
    parse_actuator(text, "my.toml");
    return {};
  } catch (const files::ConfigError& error) {
    return error.what();
  }
}

/// The preset with one line written otherwise.
std::string with(const std::string& line, const std::string& instead) {
  std::string text = preset_text();
  const std::size_t at = text.find("\n" + line);
  EXPECT_NE(at, std::string::npos) << line;
  return text.replace(at + 1, line.size(), instead);
}

TEST(ActuatorFile, ReadsEveryNumberInSiUnits) {
  const auto p = load_actuator(std::string(paper_001_actuator));
  EXPECT_EQ(p.bias.length_m, 0.2286);
  EXPECT_DOUBLE_EQ(p.bias.diameter_m, 3.81e-4);
  EXPECT_EQ(p.density_kg_m3, 6500);
  EXPECT_DOUBLE_EQ(p.ambient_K, 297.15);
  EXPECT_EQ(p.heat.heating_W_m2K, 165);
  EXPECT_EQ(p.heat.heating_W_m2K2, 0.5);
  EXPECT_EQ(p.heat.cooling_W_m2K, 300);
  EXPECT_EQ(p.heat.cooling_step_W_m2K, 150);
  EXPECT_DOUBLE_EQ(p.heat.cooling_centre_K, 321.15);
  EXPECT_EQ(p.heat.cooling_width_K, 10);
  EXPECT_EQ(p.heat.capacity_J_kgK, 1400);
  EXPECT_EQ(p.heat.capacity_step_J_kgK, 1000);
  EXPECT_DOUBLE_EQ(p.heat.capacity_centre_K, 331.15);
  EXPECT_EQ(p.heat.capacity_width_K, 0.5);
  EXPECT_DOUBLE_EQ(p.kinetics.m2a.centre_K, 352.05);
  EXPECT_EQ(p.kinetics.m2a.deviation_K, 11.2);
  EXPECT_DOUBLE_EQ(p.kinetics.a2m.centre_K, 307.15);
  EXPECT_EQ(p.kinetics.a2m.deviation_K, 5.8);
  EXPECT_EQ(p.kinetics.m2a.stress_K_Pa, 0);
  EXPECT_EQ(p.kinetics.a2m.stress_K_Pa, 0);
  EXPECT_EQ(p.bias.spring_N_m, 58.19);
  EXPECT_EQ(p.bias.deformation_m, 0.04425);
  EXPECT_DOUBLE_EQ(p.bias.austenite_Pa, 359.17e6);
  EXPECT_DOUBLE_EQ(p.bias.twinned_Pa, 204.8e6);
  EXPECT_DOUBLE_EQ(p.bias.part_twinned_Pa, 8.26e6);
  EXPECT_DOUBLE_EQ(p.bias.detwinned_Pa, 168e6);
  EXPECT_EQ(p.bias.yield_strain, 0.1);
  EXPECT_EQ(p.bias.detwinned_strain, 0.15);
  EXPECT_THAT(p.bias.smooth, testing::ElementsAre(0.0204, 0.01293, 0.0027));
  EXPECT_EQ(p.resistivity.austenite_ohm_m, 9.2e-7);
  EXPECT_EQ(p.resistivity.austenite_cold_ohm_m, 8.4e-7);
  EXPECT_EQ(p.resistivity.austenite_decay_1_K, 0.2499);
  EXPECT_EQ(p.resistivity.step_ohm_m, 3.4e-8);
  EXPECT_EQ(p.resistivity.step_ohm_m_K, 5.7e-10);
  EXPECT_DOUBLE_EQ(p.resistivity.step_centre_K, 343.15);
  EXPECT_EQ(p.resistivity.step_width_K, 3);
  EXPECT_EQ(p.resistivity.martensite_ohm_m_K[0], 8.7e-7);
  EXPECT_EQ(p.resistivity.martensite_ohm_m_K[9], 6.651e-21);
  EXPECT_DOUBLE_EQ(p.resistivity.lowest_K, 297.15);
  EXPECT_DOUBLE_EQ(p.resistivity.highest_K, 375.15);
  EXPECT_EQ(p.strain_law, StrainLaw::balance);
}

TEST(ActuatorFile, EveryUnitOfAKindIsRead) {
  const auto p = parse_actuator(with("diameter_mm = 0.381", "diameter_um = 381"), "my.toml");
  EXPECT_DOUBLE_EQ(p.bias.diameter_m, 3.81e-4);
  const auto q = parse_actuator(with("law = \"balance\"", "law = \"polynomial\""), "my.toml");
  EXPECT_EQ(q.strain_law, StrainLaw::polynomial);
}

TEST(ActuatorFile, EveryKeyIsRequired) {
  std::istringstream lines(preset_text());
  std::string line;
  int keys = 0;
  while (std::getline(lines, line)) {
    const std::size_t equals = line.find(" = ");
    // A list that goes on in the next lines cannot be left out by its first one.
    if (line.starts_with("#") || equals == std::string::npos || line.find('[') < line.size()) {
      continue;
    }
    ++keys;
    EXPECT_THAT(refusal(with(line, "")), AllOf(HasSubstr("my.toml: "), HasSubstr("is missing")))
        << line;
  }
  EXPECT_EQ(keys, 36);
}

TEST(ActuatorFile, UnknownKeysAndUnitsAreRefused) {
  EXPECT_THAT(refusal(with("length_m = 0.2286", "lenght_m = 0.2286")),
              AllOf(HasSubstr("my.toml:"), HasSubstr("wire.lenght_m = 0.2286"),
                    HasSubstr("[wire] has: length_m, diameter_m, density_kg_m3")));
  EXPECT_THAT(
      refusal(with("length_m = 0.2286", "length_inch = 9")),
      AllOf(HasSubstr("wire.length_inch = 9"), HasSubstr("length_m, length_mm, length_um")));
  EXPECT_THAT(refusal(with("cooling_step_W_m2K = 150", "cooling_step_W = 150")),
              HasSubstr("allowed: cooling_step_W_m2K"));
  EXPECT_THAT(refusal(preset_text() + "\n[colour]\nred = 1\n"),
              AllOf(HasSubstr("colour.red"), HasSubstr("unknown table")));
  EXPECT_THAT(refusal(with("length_m = 0.2286", "length_m = 0.2286\nlength_mm = 228.6")),
              HasSubstr("is given twice"));
}

TEST(ActuatorFile, ValuesOutOfRangeAreRefusedWithTheRange) {
  EXPECT_THAT(refusal(with("diameter_mm = 0.381", "diameter_mm = 381")),
              AllOf(HasSubstr("wire.diameter_mm = 381"),
                    HasSubstr("must be between 0.005 and 5 mm, is 381")));
  EXPECT_THAT(refusal(with("centre_degC = 78.9", "centre_degC = -200")),
              HasSubstr("must be between -123.15 and 326.85 degC, is -200"));
  EXPECT_THAT(refusal(with("yield = 0.1", "yield = \"much\"")),
              HasSubstr("must be a finite number"));
  EXPECT_THAT(refusal(with("yield = 0.1", "yield = nan")), HasSubstr("must be a finite number"));
  EXPECT_THAT(refusal(with("smooth = [0.0204, 0.01293, 0.0027]", "smooth = [0.02, 0.01]")),
              HasSubstr("must be a list of 3 numbers"));
  EXPECT_THAT(refusal(with("law = \"balance\"", "law = \"guess\"")),
              AllOf(HasSubstr("strain.law = "), HasSubstr("balance, polynomial")));
}

TEST(ActuatorFile, ContradictionsAreRefused) {
  const std::vector<std::vector<std::string>> cases{
      {"centre_degC = 34", "centre_degC = 80", "kinetics.m2a.centre", "must lie above"},
      {"detwinned_from = 0.15", "detwinned_from = 0.05", "strain.detwinned_from", "above"},
      {"austenite_MPa = 359.17", "austenite_MPa = 50", "spring", "can hold"},
      {"capacity_step_J_kgK = 1000", "capacity_step_J_kgK = 1500", "heat.capacity_step", "1400"},
      {"cooling_step_W_m2K = 150", "cooling_step_W_m2K = 400", "heat.cooling_step", "300"},
      {"heating_slope_W_m2K2 = 0.5", "heating_slope_W_m2K2 = 5", "heat.heating_slope", "positive"},
      {"highest_degC = 102", "highest_degC = 20", "resistivity.highest", "above"},
      {"step_slope_ohm_m_K = 5.7e-10", "step_slope_ohm_m_K = 5.7e-8", "resistivity.martensite",
       "must be positive"}};
  for (const auto& c : cases) {
    EXPECT_THAT(refusal(with(c[0], c[1])), AllOf(HasSubstr(c[2]), HasSubstr(c[3]))) << c[1];
  }
}

TEST(ActuatorFile, BrokenOrMissingFilesAreNamed) {
  EXPECT_THAT(refusal("[wire\n"), HasSubstr("my.toml:1:"));
  const auto refused = [](const std::string& name) {
    try {
      load_actuator(name);
    } catch (const files::ConfigError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(refused("no-such.toml"), HasSubstr("no-such.toml: cannot be read"));
  EXPECT_THAT(refused("thick"),
              AllOf(HasSubstr("thick"), HasSubstr(std::string(paper_001_actuator))));

  const std::string file = testing::TempDir() + "/actuator.toml";
  std::ofstream(file) << preset_text();
  EXPECT_EQ(load_actuator(file).bias.spring_N_m, 58.19);
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace smaservo::papers
