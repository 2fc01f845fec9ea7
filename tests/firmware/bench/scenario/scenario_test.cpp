#include "firmware/bench/scenario/scenario.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numeric>

#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"
#include "tests/places.hpp"

namespace smaservo::test::scenario_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;

fs::path traces() {
  return fs::path(test::source_folder()) / "host-sim/traces";
}

constexpr std::string_view good = R"(note = "a test"
wire = "smartflex-76um"
seed = 1
scatter_K = 0.5

[joule]
ambient_degC = 25
draught = 1
overheat_K = 12
min_current_mA = 12
rate_Hz = 100

[joule.load]
type = "constant"
stress_MPa = 150

[joule.sensors]
bits = 16
current_full_scale_mA = 500
voltage_full_scale_V = 20
load_full_scale_N = 5
current_noise_uA = 10
voltage_noise_mV = 0.3
load_noise_mN = 2.3
load_gain_error_percent = 0.2
resistance_drift_percent = 0

[[joule.drive]]
level = 1
for_s = 2

[[joule.drive]]
random = [0, 1]
each_s = [0.3, 3]
for_s = 20

[[joule.drive]]
center = 0.55
shrinking = 0.4
factor = 0.5
each_s = 1.5
loops = 2
)";

/// `good` with one line, which must stand in it, replaced.
std::string with(std::string_view line, std::string_view other) {
  std::string text{good};
  const std::size_t at = text.find(line);
  EXPECT_NE(at, std::string::npos) << line;
  return text.replace(at, line.size(), other);
}

bench::Scenario load(std::string_view text) {
  const TemporaryFolder folder;
  return bench::load_scenario(folder.write("s.toml", text));
}

/// What is said about a scenario that is refused, without the folder.
std::string refusal(std::string_view text) {
  const TemporaryFolder folder;
  try {
    bench::load_scenario(folder.write("s.toml", text));
  } catch (const std::runtime_error& error) {
    const std::string message = error.what();
    const std::string prefix = folder / "";
    return message.starts_with(prefix) ? message.substr(prefix.size()) : message;
  }
  return "";
}

TEST(Scenario, EveryShippedOneLoadsAndHasItsTrace) {
  int found = 0;
  for (const auto& entry : fs::directory_iterator(traces())) {
    if (entry.path().extension() == ".toml") {
      ++found;
      const bench::Scenario scenario = bench::load_scenario(entry.path());
      EXPECT_FALSE(scenario.note.empty());
      EXPECT_TRUE(fs::exists(fs::path(entry.path()).replace_extension(".csv"))) << entry.path();
    } else if (entry.path().extension() == ".csv") {
      EXPECT_TRUE(fs::exists(fs::path(entry.path()).replace_extension(".toml"))) << entry.path();
    }
  }
  EXPECT_GE(found, 12);
}

TEST(Scenario, NumbersBecomeSi) {
  const bench::Scenario scenario = load(good);
  const auto& joule = std::get<bench::JouleScenario>(scenario.run);
  EXPECT_EQ(scenario.seed, 1U);
  EXPECT_DOUBLE_EQ(joule.ambient_K, room_K);
  EXPECT_DOUBLE_EQ(joule.min_current_A, 0.012);
  EXPECT_DOUBLE_EQ(std::get<hal::ConstantLoad>(joule.load).stress_Pa, 150e6);
  EXPECT_DOUBLE_EQ(joule.sensors.current_full_scale_A, 0.5);
  EXPECT_DOUBLE_EQ(joule.sensors.current_noise_A, 1e-5);
  EXPECT_DOUBLE_EQ(joule.sensors.load_gain, 1.002);
}

TEST(Scenario, DriveIsWhatTheFileSays) {
  const bench::Scenario scenario = load(good);
  const auto& drive = std::get<bench::JouleScenario>(scenario.run).drive;
  ASSERT_GE(drive.size(), 5U);
  EXPECT_EQ(drive.front().level, 1);
  const double seconds =
      std::accumulate(drive.begin(), drive.end(), 0.0,
                      [](double sum, const bench::DriveStep& s) { return sum + s.seconds; });
  EXPECT_NEAR(seconds, 2 + 20 + 4 * 1.5, 1e-9);
  const std::size_t loops = drive.size() - 4;
  for (std::size_t i = 1; i < loops; ++i) {
    EXPECT_TRUE(drive[i].level >= 0 && drive[i].level <= 1);
    EXPECT_TRUE(drive[i].seconds <= 3 && (drive[i].seconds >= 0.3 || i + 1 == loops));
  }
  const double levels[] = {0.95, 0.15, 0.75, 0.35};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(drive[loops + i].level, levels[i], 1e-12);
  }
}

TEST(Scenario, SeedDecidesTheDrive) {
  const auto levels = [](const bench::Scenario& scenario) {
    std::vector<double> all;
    for (const bench::DriveStep& step : std::get<bench::JouleScenario>(scenario.run).drive) {
      all.push_back(step.level);
    }
    return all;
  };
  EXPECT_EQ(levels(load(good)), levels(load(good)));
  EXPECT_NE(levels(load(good)), levels(load(with("seed = 1", "seed = 2"))));
}

TEST(Scenario, FamilyIsIhypUnlessTheFileSaysOtherwise) {
  EXPECT_EQ(load(good).family, hal::Family::ihyp);
  for (const hal::Family family : hal::families) {
    const std::string key = "seed = 1\nfamily = \"" + std::string(hal::family_name(family)) + "\"";
    EXPECT_EQ(load(with("seed = 1", key)).family, family);
  }
}

TEST(Scenario, ALevelMayRipple) {
  const bench::Scenario scenario =
      load(with("for_s = 2", "for_s = 2\nripple = 0.5\nripple_Hz = 4"));
  const auto& drive = std::get<bench::JouleScenario>(scenario.run).drive;
  EXPECT_EQ(drive.front().ripple, 0.5);
  EXPECT_EQ(drive.front().ripple_Hz, 4);
  EXPECT_EQ(drive.back().ripple, 0);
}

TEST(Scenario, ALevelMayHaveADraught) {
  const bench::Scenario scenario = load(with("for_s = 2", "for_s = 2\ndraught = 2.5"));
  const auto& drive = std::get<bench::JouleScenario>(scenario.run).drive;
  EXPECT_EQ(drive.front().draught, 2.5);
  EXPECT_EQ(drive.back().draught, 1);
}

struct Mistake {
  const char* line;
  const char* other;
  const char* said;
};

TEST(Scenario, MistakesAreNamedWithLineKeyValueAndRange) {
  const Mistake mistakes[] = {
      {"seed = 1", "seed = -1", "s.toml:3: seed = -1: must be a number between 0 and 1000000000"},
      {"seed = 1", "seed = '1'", "s.toml:3: seed = '1': must be a number between 0 and 1000000000"},
      {"scatter_K = 0.5\n", "", "scatter_K: is missing"},
      {"ambient_degC = 25", "ambient_degC = 300",
       "s.toml:7: joule.ambient_degC = 300: must be a number between -40 and 80"},
      {"ambient_degC = 25", "ambient_degC = nan",
       "s.toml:7: joule.ambient_degC = nan: must be a number between -40 and 80"},
      {"draught = 1", "drought = 1", "joule.draught: is missing"},
      {"draught = 1", "draught = 1\nwind = 2", "s.toml:9: joule.wind = 2: unknown key; allowed: "},
      {"rate_Hz = 100", "rate_Hz = 300", "s.toml:11: joule.rate_Hz = 300: must divide 1000"},
      {"type = \"constant\"", "type = \"weight\"",
       "s.toml:14: joule.load.type = 'weight': must be one of: constant, spring, varying"},
      {"stress_MPa = 150", "stress_MPa = 1001",
       "s.toml:15: joule.load.stress_MPa = 1001: must be a number between 0 and 1000"},
      {"bits = 16", "bits = 7", "s.toml:18: joule.sensors.bits = 7: must be a number between 8 "},
      {"level = 1", "level = 3", "s.toml:29: joule.drive.level = 3: must be a number between 0 "},
      {"level = 1", "power = 3",
       "joule.drive.level: is missing; give one of level, shrinking, random"},
      {"random = [0, 1]", "random = [0]", "s.toml:33: joule.drive.random = [ 0 ]: "},
      {"random = [0, 1]", "random = []", "s.toml:33: joule.drive.random = []: must be a list"},
      {"random = [0, 1]", "random = [0, 'x']", "s.toml:33: joule.drive.random = "},
      {"random = [0, 1]", "random = [1, 0]", "s.toml:33: joule.drive.random = [ 1, 0 ]: "},
      {"each_s = [0.3, 3]", "each_s = [3, 0.3]", "joule.drive."},
      {"factor = 0.5", "factor = 2", "s.toml:40: joule.drive.factor = 2: must be a number "},
      {"note = \"a test\"\n", "", "note: is missing"},
      {"[joule.load]", "[joule.weight]", "joule.load: is missing"},
      {"seed = 1", "seed = 1\nfamily = \"cosine\"",
       "s.toml:4: family = 'cosine': must be one of: ihyp, sublayers"},
      {"for_s = 2\n", "for_s = 2\nripple = 0.5\n", "joule.drive.ripple_Hz: is missing"},
      {"for_s = 2\n", "for_s = 2\ndraught = 0\n", "joule.drive.draught = 0: "},
      {"seed = 1", "seed = = 1", "s.toml:3:8: "},
  };
  for (const Mistake& mistake : mistakes) {
    const std::string said = refusal(with(mistake.line, mistake.other));
    EXPECT_THAT(said, HasSubstr(mistake.said)) << mistake.other;
    EXPECT_THAT(said, StartsWith("s.toml:"));
  }
}

TEST(Scenario, AWireThatIsNotThereIsNamed) {
  EXPECT_THAT(refusal(with("smartflex-76um", "smartflex-77um")), HasSubstr("smartflex-77um"));
  EXPECT_THAT(refusal(with("smartflex-76um", "units/c.toml")), HasSubstr("c.toml"));
  EXPECT_THROW(bench::load_scenario(traces() / "missing.toml"), files::UserError);
}

TEST(Scenario, AWireIsLookedForBesideTheScenario) {
  const TemporaryFolder folder;
  folder.write("w.toml",
               "name = \"mine\"\nbased_on = \"smartflex-76um\"\n[wire]\nlength_mm = 55\n");
  const bench::Scenario scenario =
      bench::load_scenario(folder.write("s.toml", with("smartflex-76um", "w.toml")));
  EXPECT_DOUBLE_EQ(scenario.wire.wire.geometry.length_m, 0.055);
}

}  // namespace
}  // namespace smaservo::test::scenario_test
