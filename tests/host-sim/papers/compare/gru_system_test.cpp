// A trained network as one of the systems.

#include <cmath>
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "host-sim/papers/compare/system.hpp"
#include "tests/host-sim/papers/gru/small_network.hpp"
#include "tests/host-sim/replay/replays.hpp"

namespace smaservo::test {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsNan;
using GruRun = smaservo::identify::Run;
constexpr double no_reading = std::numeric_limits<double>::quiet_NaN();

const gru::Network& shipped_network() {
  static const gru::Network network = gru::load_network(
      (std::filesystem::path(source_folder()) / "host-sim/papers/gru/traces.json").string());
  return network;
}

GruRun trace_of_unit_a(const std::string& name) {
  const Wire<double> wire = files::load_wire("smartflex-76um", {{"wire.length_mm", "100.6"}}).wire;
  return identify::read_run(shipped(name + ".csv"), {wire.geometry, {}, {}, {}});
}

std::vector<double> strain_of(const gru::Network& network, const GruRun& run) {
  return compare::recurrent_network(network, {}, {}).strain(run);
}

double mean_percent(const std::vector<double>& strain, const GruRun& run) {
  double sum = 0;
  for (std::size_t i = 0; i < strain.size(); ++i) {
    sum += std::abs(strain[i] - run.strain[i]) / 0.04 * 100;
  }
  return sum / static_cast<double>(strain.size());
}

using Columns = std::vector<double> GruRun::*;
constexpr Columns columns[] = {&GruRun::time_s,    &GruRun::current_A, &GruRun::voltage_V,
                               &GruRun::stress_Pa, &GruRun::strain,    &GruRun::resistance_ohm};

/// A smooth run without noise.
GruRun smooth_run(double step_s, double seconds = 12) {
  GruRun run{};
  run.name = "smooth.csv";
  run.kind = identify::RunKind::joule;
  for (int i = 0; i * step_s <= seconds + 1e-9; ++i) {
    const double t = i * step_s;
    const double heat = 0.5 - 0.5 * std::cos(t);
    const double ohm = 20 - 2 * heat;
    run.time_s.push_back(t);
    run.current_A.push_back(0.02 + 0.15 * heat);
    run.resistance_ohm.push_back(ohm);
    run.voltage_V.push_back(ohm * run.current_A.back());
    run.stress_Pa.push_back(150e6 + 30e6 * std::sin(0.7 * t));
    run.strain.push_back(0.04 * (1 - heat));
  }
  return run;
}

/// What tests/python/gru_test.py has computed with numpy, of rows of two traces.
TEST(GruSystem, IsWhatTheTrainingProgramComputes) {
  const NumberTable golden = parse_numbers(
      file_text(std::filesystem::path(source_folder()) / "tests/golden/gru_strains.csv"));
  ASSERT_EQ(golden.names, (std::vector<std::string>{"load_MPa", "row", "strain"}));
  for (const auto& [name, load_MPa] : {std::pair{"spring", 0.0}, std::pair{"150MPa", 150.0}}) {
    const std::vector<double> strain = strain_of(shipped_network(), trace_of_unit_a(name));
    int compared = 0;
    for (std::size_t i = 0; i < golden.rows(); ++i) {
      if (golden.columns[0][i] == load_MPa) {
        ++compared;
        const auto row = static_cast<std::size_t>(golden.columns[1][i]);
        EXPECT_NEAR(strain.at(row), golden.columns[2][i], 1e-9) << name << " row " << row;
      }
    }
    EXPECT_GT(compared, 30);
  }
}

TEST(GruSystem, DoesNotDependOnTheRateOfTheRows) {
  const GruRun often = smooth_run(0.005);
  const std::vector<double> fine = strain_of(shipped_network(), often);
  EXPECT_EQ(strain_of(shipped_network(), often), fine) << "nor on anything else";
  double moved = 0;
  for (const int every : {2, 4, 7}) {  // rows each 10, 20 and 35 ms
    const std::vector<double> coarse = strain_of(shipped_network(), smooth_run(0.005 * every));
    for (std::size_t i = 0; i < coarse.size(); ++i) {
      const std::size_t same = i * static_cast<std::size_t>(every);
      EXPECT_NEAR(coarse[i], fine[same], 0.04 * 0.01) << every << " at " << often.time_s[same];
      moved = std::max(moved, std::abs(coarse[i] - coarse[0]));
    }
  }
  EXPECT_GT(moved, 0.01) << "else nothing was tested";
}

TEST(GruSystem, HoldsTheStrainWhereThereIsNoResistance) {
  GruRun run = smooth_run(0.01);
  for (const std::size_t i : {0U, 1U, 400U, 401U, 402U}) {
    run.resistance_ohm[i] = no_reading;
  }
  run.resistance_ohm[600] = 0;
  const std::vector<double> strain = strain_of(shipped_network(), run);
  EXPECT_TRUE(std::isnan(strain[0]) && std::isnan(strain[1])) << "nothing to hold yet";
  EXPECT_TRUE(std::isfinite(strain[2]));
  EXPECT_EQ(strain[402], strain[399]);
  EXPECT_NE(strain[403], strain[399]);
  EXPECT_EQ(strain[600], strain[599]);
  EXPECT_LT(std::abs(strain.back() - strain_of(shipped_network(), smooth_run(0.01)).back()), 1e-3);
}

TEST(GruSystem, StartsAnewBehindALongGap) {
  const GruRun whole = smooth_run(0.01);
  GruRun parts = whole;
  for (const Columns column : columns) {
    const std::vector<double> once = parts.*column;
    (parts.*column).insert((parts.*column).end(), once.begin(), once.end());
  }
  const std::size_t rows = whole.time_s.size();
  for (std::size_t i = rows; i < 2 * rows; ++i) {
    parts.time_s[i] += 1e9;
  }
  const std::vector<double> once = strain_of(shipped_network(), whole);
  const std::vector<double> twice = strain_of(shipped_network(), parts);
  for (std::size_t i = 0; i < rows; ++i) {
    EXPECT_EQ(twice[i], once[i]);
    EXPECT_NEAR(twice[rows + i], once[i], 1e-6) << i;  // of times as large, with fewer digits
  }
}

TEST(GruSystem, SaysNothingWhereThereIsNoPowerOrNoResistance) {
  GruRun bath = smooth_run(0.01);
  bath.kind = identify::RunKind::bath;
  bath.temperature_K.assign(bath.strain.size(), 300);
  bath.time_s.clear();
  bath.current_A.clear();
  bath.voltage_V.clear();
  EXPECT_THAT(strain_of(shipped_network(), bath), Each(IsNan()));
  GruRun blind = smooth_run(0.01);
  blind.resistance_ohm.assign(blind.strain.size(), no_reading);
  EXPECT_THAT(strain_of(shipped_network(), blind), Each(IsNan()));
  EXPECT_EQ(strain_of(shipped_network(), blind).size(), blind.strain.size());
}

TEST(GruSystem, SaysWhatItWasTrainedOn) {
  nlohmann::ordered_json json = small_network();
  GruRun run = smooth_run(0.01), other = run;
  other.strain[7] += 1e-12;
  json["runs"][0]["checksum"] = gru::checksum_of(run.strain);
  const gru::Network network = gru::parse_network("gru.json", json.dump());
  const auto remark = [&](const std::vector<GruRun>& training, const std::vector<GruRun>& tests) {
    return compare::recurrent_network(network, training, tests).remark;
  };
  EXPECT_EQ(remark({run}, {other}), "");
  run.name = "folder/renamed.csv";
  EXPECT_EQ(remark({run}, {other}), "") << "whatever it is called";
  EXPECT_EQ(remark({other}, {run}),
            "was trained on runs that are tests here, so its errors there prove nothing: "
            "renamed.csv; was "
            "trained on other runs than the other systems: a.csv");
  EXPECT_EQ(remark({run, other}, {other}),
            "was trained on other runs than the other systems: a.csv");
}

/// Python wrote the checksums of these runs.
TEST(GruSystem, TheShippedNetworkKnowsItsRuns) {
  std::vector<GruRun> training;
  for (const char* name : {"10MPa", "50MPa", "150MPa", "400MPa"}) {
    training.push_back(trace_of_unit_a(name));
  }
  const GruRun spring = trace_of_unit_a("spring");
  EXPECT_EQ(compare::recurrent_network(shipped_network(), training, {spring}).remark, "");
}

/// Both sides: a network that became much better has seen a test.
TEST(GruSystem, ItsErrorsAreThoseOfTheReadme) {
  for (const auto& [name, percent] : {std::pair{"spring", 1.50}, std::pair{"disturbed", 2.31}}) {
    const GruRun run = trace_of_unit_a(name);
    EXPECT_NEAR(mean_percent(strain_of(shipped_network(), run), run), percent, 0.01) << name;
  }
}

}  // namespace
}  // namespace smaservo::test
