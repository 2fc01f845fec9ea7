// The shipped traces come from their scenarios.

#include "host-sim/simulate/simulate.hpp"

#include <gtest/gtest.h>

#include "hal/recording/trace_file.hpp"
#include "tests/host-sim/replay/replays.hpp"

namespace smaservo::test {
namespace {

namespace fs = std::filesystem;

std::string simulated(const bench::Scenario& scenario) {
  const TemporaryFolder folder;
  hal::TraceFile file(folder / "t.csv", {"test", "test"});
  simulate::simulate(scenario, file);
  file.commit();
  return file_text(folder / "t.csv");
}

std::vector<std::string> scenarios() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(shipped(""))) {
    if (entry.path().extension() == ".toml") {
      names.push_back(entry.path().stem().string());
    }
  }
  std::ranges::sort(names);
  return names;
}

class Simulated : public ::testing::TestWithParam<std::string> {
 protected:
  static bench::Scenario scenario() { return bench::load_scenario(shipped(GetParam() + ".toml")); }
  static std::string trace() { return file_text(shipped(GetParam() + ".csv")); }
};

/// The drive cut off after this time; a bath has no time and stays whole.
bench::Scenario shortened(bench::Scenario scenario, double seconds) {
  if (auto* joule = std::get_if<bench::JouleScenario>(&scenario.run)) {
    std::vector<bench::DriveStep> drive;
    double left_s = joule->record_from_s + seconds;
    for (bench::DriveStep step : joule->drive) {
      step.seconds = std::min(step.seconds, left_s);
      left_s -= step.seconds;
      drive.push_back(step);
      if (left_s <= 0) {
        break;
      }
    }
    joule->drive = drive;
  }
  return scenario;
}

// The sanitizers make it fifty times slower: there the first seconds must do.
#ifdef SMASERVO_SANITIZED
constexpr bool whole = false;
#else
constexpr bool whole = true;
#endif

// The traces were made by g++ on x86-64. There they come out again to the last byte, with any
// optimisation.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__)
TEST_P(Simulated, GivesTheShippedTraceByteForByte) {
  const std::string shipped_text = trace();
  const std::string again = simulated(whole ? scenario() : shortened(scenario(), 3));
  const std::size_t length = whole ? shipped_text.size() : again.size();
  ASSERT_GT(again.size(), 1000U);
  EXPECT_TRUE(again == shipped_text.substr(0, length))
      << "if the plant was changed on purpose: host-sim simulate host-sim/traces/" << GetParam()
      << ".toml --out host-sim/traces/" << GetParam() << ".csv";
}
#endif

// Elsewhere the last bits differ, and a turning point that one compiler sees a step sooner than
// another moves the loops that follow. clang++ against g++ on the same machine: up to 0.7 % of a
// column's range where the load is noisy, at most 0.06 % elsewhere, nothing in many rows.
TEST_P(Simulated, GivesTheShippedTraceOnAnyCompiler) {
  const NumberTable now = parse_numbers(simulated(whole ? scenario() : shortened(scenario(), 3)));
  const NumberTable before = parse_numbers(trace());
  ASSERT_EQ(now.names, before.names);
  ASSERT_LE(now.rows(), before.rows());
  ASSERT_GE(now.rows(), whole ? before.rows() : 300U);
  for (std::size_t i = 0; i < now.columns.size(); ++i) {
    EXPECT_LE(max_difference(now.columns[i], before.columns[i]),
              0.02 * range(before.columns[i]) + 1e-12)
        << now.names[i];
  }
}

const auto scenario_name = [](const ::testing::TestParamInfo<std::string>& tested) {
  std::string name = tested.param;
  std::erase(name, '-');
  return name;
};
INSTANTIATE_TEST_SUITE_P(Shipped, Simulated, ::testing::ValuesIn(scenarios()), scenario_name);

TEST(Simulate, SeedChangesTheNoiseOnly) {
  bench::Scenario scenario = shortened(bench::load_scenario(shipped("200MPa.toml")), 2);
  scenario.scatter_K = 0;
  const NumberTable one = parse_numbers(simulated(scenario));
  scenario.seed += 1;
  const NumberTable other = parse_numbers(simulated(scenario));
  const auto column = [&](const NumberTable& t, std::size_t i) { return t.columns.at(i); };
  EXPECT_GT(max_difference(column(one, 3), column(other, 3)), 1e-3) << "load";
  EXPECT_EQ(max_difference(column(one, 4), column(other, 4)), 0) << "strain";
}

TEST(Simulate, HeatShortensAndWeightStretches) {
  bench::Scenario scenario = bench::load_scenario(shipped("200MPa.toml"));
  auto& joule = std::get<bench::JouleScenario>(scenario.run);
  joule.drive = {{0, 1}, {1, 4}, {0, 4}};
  const NumberTable t = parse_numbers(simulated(scenario));
  const std::vector<double>& strain = t.columns.at(4);
  ASSERT_EQ(strain.size(), 900U);
  EXPECT_GT(strain[99], 0.04);
  EXPECT_LT(strain[499], 0.01);
  EXPECT_GT(strain[899], 0.035);
  // Readings stay on the grid of the converter, and Ohm's law holds between them.
  const double step_A = joule.sensors.current_full_scale_A / 32768;
  for (std::size_t i = 0; i < strain.size(); ++i) {
    const double steps = t.columns[1][i] / step_A;
    ASSERT_NEAR(steps, std::round(steps), 0.04);
    const double ohm = t.columns[2][i] / t.columns[1][i];
    ASSERT_TRUE(ohm > 18 && ohm < 27) << ohm;
  }
}

}  // namespace
}  // namespace smaservo::test
