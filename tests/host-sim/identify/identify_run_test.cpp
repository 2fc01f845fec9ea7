#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

#include "host-sim/identify/runs/run.hpp"
#include "model/files/error.hpp"
#include "model/units.hpp"
#include "tests/host-sim/recordings.hpp"
#include "tests/host-sim/replay/measured_data.hpp"
#include "tests/places.hpp"

namespace smaservo::test {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;
using Columns = std::vector<RecordedColumn>;
using Values = std::vector<double>;

/// The message that refuses a run, without the file's name; empty if the run is accepted.
std::string refusal(const Columns& columns,
                    const identify::RunOptions& options = of_recorded_wire()) {
  const TemporaryFolder folder;
  const std::string path = folder.write("run.csv", csv(columns));
  try {
    identify::read_run(path, options);
  } catch (const files::UserError& error) {
    const std::string said = error.what();
    return said.starts_with(path + ": ") ? said.substr(path.size() + 2) : "without name: " + said;
  }
  return "";
}

TEST(RunKinds, ABathNeedsNoTime) {
  const Recording r;
  const auto run = run_of(
      {{"temperature_degC", r.temperature_degC}, {"strain_ref_percent", times(100, r.strain)}});
  EXPECT_EQ(run.kind, identify::RunKind::bath);
  ASSERT_EQ(run.strain.size(), 200U);
  EXPECT_DOUBLE_EQ(run.temperature_K[0], 293.15);
  EXPECT_NEAR(run.strain[37], r.strain[37], 1e-15);
  EXPECT_THAT(run.stress_Pa, Each(150e6));
  EXPECT_THAT(run.time_s, IsEmpty());
  EXPECT_THAT(run.resistance_ohm, IsEmpty());
  EXPECT_THAT(run.power_W_kg, IsEmpty());
}

TEST(RunKinds, AMeasuringCurrentMakesNoHeating) {
  const Recording r;
  Columns columns{{"time_s", r.time_s},
                  {"temperature_degC", r.temperature_degC},
                  {"current_mA", Values(200, 5.0)},
                  {"voltage_mV", times(5, r.ohm)}};
  const auto bath = run_of(columns);
  EXPECT_EQ(bath.kind, identify::RunKind::bath);
  for (std::size_t i = 0; i < 200; ++i) {
    ASSERT_NEAR(bath.resistance_ohm[i], r.ohm[i], 1e-12);
  }
  // A measuring current may heat the wire with 0.1 W/m, here with 21 mA (22 ohm, 100 mm); 25 mA are
  // too much.
  columns[2].values.back() = 25;
  columns[3].values.back() *= 5;
  EXPECT_THAT(refusal(columns), HasSubstr("fit a joule run"));
}

TEST(RunKinds, CurrentVoltageAndTimeAreJouleHeatingWhateverAThermometerSays) {
  const Recording r;
  const auto run = run_of({{"time_s", r.time_s},
                           {"current_A", r.current_A},
                           {"voltage_V", r.voltage_V},
                           {"temperature_degC", converted(r.temperature_degC, 0.1, 20, 80)},
                           {"ambient_degC", Values(200, 22.0)},
                           {"strain_ref", r.strain}});
  EXPECT_EQ(run.kind, identify::RunKind::joule);
  EXPECT_EQ(run.temperature_K.size(), 200U);
  EXPECT_THAT(run.ambient_K, Each(295.15));
  EXPECT_NEAR(run.resistance_ohm[100], r.ohm[100], 1e-12);
}

TEST(RunKinds, WithoutTimeEachRowIsSettled) {
  const Recording r;
  Values displacement_mm;
  for (const double strain : r.strain) {
    displacement_mm.push_back(7 - 100 * strain);
  }
  const Columns columns{{"current_A", r.current_A},
                        {"voltage_V", r.voltage_V},
                        {"displacement_mm", displacement_mm},
                        {"temperature_degC", r.temperature_degC}};
  const auto run = run_of(columns);
  EXPECT_EQ(run.kind, identify::RunKind::settled);
  EXPECT_DOUBLE_EQ(*std::ranges::max_element(run.strain), 0);
  EXPECT_NEAR(run.strain[90] - run.strain[10], r.strain[90] - r.strain[10], 1e-12);
  EXPECT_TRUE(std::isnan(run.resistance_ohm[0])) << "there is no current";
  EXPECT_TRUE(std::isnan(run.resistance_ohm[2])) << "2 % of the largest";
  EXPECT_NEAR(run.resistance_ohm[4], r.ohm[4], 1e-12);
  identify::RunOptions period = of_recorded_wire();
  period.trace.period_s = 0.1;
  EXPECT_EQ(run_of(columns, period).kind, identify::RunKind::joule) << "rows have a time";
}

TEST(RunKinds, PowerIsACalorimeters) {
  const Recording r;
  for (const char* name : {"power_W_per_g", "power_mW_per_mg"}) {
    const auto run = run_of({{"temperature_degC", r.temperature_degC}, {name, Values(200, 0.5)}});
    EXPECT_EQ(run.kind, identify::RunKind::calorimetry);
    EXPECT_THAT(run.power_W_kg, Each(500.0));
    EXPECT_THAT(run.stress_Pa, Each(0.0)) << "the wire's load is not the sample's";
  }
  EXPECT_THAT(refusal({{"time_s", r.time_s}, {"power_W_per_g", Values(200, 0.5)}}),
              HasSubstr("no temperature"));
}

TEST(RunKinds, WhatSaysTooLittleIsRefused) {
  const Recording r;
  EXPECT_THAT(refusal({{"time_s", r.time_s}, {"strain_ref", r.strain}}),
              HasSubstr("does not tell the wire's temperature"));
  EXPECT_THAT(refusal({{"time_s", r.time_s}, {"current_A", r.current_A}, {"strain_ref", r.strain}}),
              HasSubstr("no voltage"));
  EXPECT_THAT(refusal({{"temperature_degC", r.temperature_degC},
                       {"current_A", r.current_A},
                       {"strain_ref", r.strain}}),
              HasSubstr("no voltage"))
      << "heated, so the thermometer does not count";
  EXPECT_THAT(refusal({{"temperature_degC", r.temperature_degC}}), HasSubstr("nothing to fit"));
  EXPECT_THAT(refusal({{"current_A", r.current_A}, {"voltage_V", r.voltage_V}}),
              HasSubstr("nothing to fit"));
}

TEST(RunStress, TheFileCountsBeforeWhatIsGiven) {
  const Recording r;
  const Columns bath{{"temperature_degC", r.temperature_degC}, {"strain_ref", r.strain}};
  Columns own = bath;
  own.push_back({"load_N", Values(200, 0.5)});
  const double area_m2 = recorded_wire.area_m2();
  EXPECT_THAT(run_of(own).stress_Pa, Each(0.5 / area_m2));
  own.push_back({"stress_MPa", Values(200, 80.0)});
  EXPECT_THAT(run_of(own).stress_Pa, Each(80e6));
  EXPECT_THAT(run_of(bath, {recorded_wire, {}, 0.25, {}}).stress_Pa, Each(0.25 / area_m2));
  EXPECT_THAT(refusal(bath, {recorded_wire, {}, {}, {}}), HasSubstr("--load-N"));
}

TEST(RunChecks, TooShortOrWithoutMotion) {
  const Recording r;
  const Recording few(19);
  EXPECT_THAT(refusal({{"temperature_degC", few.temperature_degC}, {"strain_ref", few.strain}}),
              StartsWith("has 19 rows"));
  Values still = times(0.07, r.strain);
  EXPECT_THAT(refusal({{"temperature_degC", r.temperature_degC}, {"strain_ref", still}}),
              HasSubstr("does not move"));
  still[50] = 0.04;
  EXPECT_THAT(refusal({{"temperature_degC", r.temperature_degC}, {"strain_ref", still}}),
              HasSubstr("does not move"))
      << "one wild row is no motion";
  EXPECT_EQ(refusal({{"temperature_degC", r.temperature_degC},
                     {"strain_ref", still},
                     {"resistance_ohm", r.ohm}}),
            "")
      << "a wire that is held transforms all the same";
  EXPECT_THAT(refusal({{"temperature_degC", Values(200, 30.0)}, {"power_W_per_g", r.ohm}}),
              HasSubstr("spans 0.0 K"));
}

TEST(RunChecks, ContradictoryUnits) {
  const Recording r;
  const RecordedColumn warm{"temperature_degC", r.temperature_degC};
  const RecordedColumn strain{"strain_ref", r.strain};
  EXPECT_THAT(refusal({warm, {"strain_ref", times(20, r.strain)}}), HasSubstr("per cent"));
  EXPECT_THAT(refusal({warm, strain, {"stress_MPa", Values(200, 1501.0)}}), HasSubstr("1501"));
  EXPECT_THAT(refusal({warm, strain, {"load_N", Values(200, 100.0)}}),
              HasSubstr("grams: --column load=3:gf"));
  EXPECT_THAT(refusal({{"temperature_K", converted(r.temperature_degC, 0.1, 60, 120)}, strain}),
              HasSubstr("degC in a column of K?"));
  Values kelvin = r.temperature_degC;
  std::ranges::for_each(kelvin, [](double& T) { T += zero_degC_K; });
  EXPECT_THAT(refusal({{"temperature_degC", kelvin}, strain}), HasSubstr("K in a column of degC?"));
  EXPECT_THAT(refusal({warm, strain, {"resistance_ohm", times(1e-3, r.ohm)}}), HasSubstr("uohm_m"));
  const RecordedColumn time{"time_s", r.time_s};
  EXPECT_THAT(
      refusal({time, {"current_A", times(1e3, r.current_A)}, {"voltage_V", r.voltage_V}, strain}),
      HasSubstr("uohm_m"))
      << "mA read as A";
  EXPECT_THAT(refusal({time,
                       {"current_A", times(100, r.current_A)},
                       {"voltage_V", times(100, r.voltage_V)},
                       strain}),
              HasSubstr("K/s"));
  identify::RunOptions thick = of_recorded_wire();
  thick.geometry.diameter_m = 300e-6;
  EXPECT_THAT(refusal({warm, strain, {"resistance_ohm", r.ohm}}, thick), HasSubstr("300 um"));
}

/// The range of a sensor ends before the motion does.
TEST(ClippedColumns, AreRefused) {
  const Recording r;
  const RecordedColumn warm{"temperature_degC", r.temperature_degC};
  const std::string cold_end = refusal({warm, {"strain_ref", converted(r.strain, 1e-5, 0, 0.03)}});
  EXPECT_THAT(cold_end, AllOf(StartsWith("strain stands still at 0.03"), HasSubstr("clipped")));
  EXPECT_THAT(refusal({warm, {"strain_ref", converted(r.strain, 1e-5, 0.012, 1)}}),
              StartsWith("strain stands still at 0.012"));
  EXPECT_THAT(refusal({warm, {"resistance_ohm", converted(r.ohm, 1e-3, 20, 100)}}),
              StartsWith("resistance stands still at 20"));
  EXPECT_THAT(refusal({{"temperature_degC", converted(r.temperature_degC, 0.1, 0, 65)},
                       {"strain_ref", r.strain}}),
              StartsWith("temperature stands still at 338.15"));
}

TEST(ClippedColumns, AreRefusedInNoise) {
  const Recording slow(20'000);
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0, 5e-5);
  Values strain = slow.strain;
  std::ranges::for_each(strain, [&](double& value) { value += noise(random); });
  const RecordedColumn warm{"temperature_degC", slow.temperature_degC};
  EXPECT_THAT(refusal({warm, {"strain_ref", converted(strain, 1e-5, 0, 0.035)}}),
              StartsWith("strain stands still"));
  EXPECT_EQ(refusal({warm, {"strain_ref", converted(strain, 1e-5, 0, 0.05)}}), "");
}

TEST(ClippedColumns, VoltageAndCurrentBeyondWhatAWireCanDo) {
  const Recording r;
  const RecordedColumn time{"time_s", r.time_s}, strain{"strain_ref", r.strain};
  EXPECT_THAT(refusal({time,
                       strain,
                       {"current_A", r.current_A},
                       {"voltage_V", converted(r.voltage_V, 1e-3, 0, 3)}}),
              StartsWith("voltage stands still at 3 "));
  EXPECT_THAT(refusal({time,
                       strain,
                       {"current_A", converted(r.current_A, 1e-4, 0, 0.1)},
                       {"voltage_V", r.voltage_V}}),
              StartsWith("current stands still at 0.1 "));
}

TEST(UnclippedColumns, CoarseConvertersFastAndSlow) {
  for (const std::size_t rows : {40U, 50U, 100U, 200U, 1000U, 20'000U}) {
    const Recording r(rows);
    for (const double step : {1e-6, 1e-5, 1e-4, 5e-4}) {
      EXPECT_EQ(refusal({{"temperature_degC", converted(r.temperature_degC, 0.5)},
                         {"strain_ref", converted(r.strain, step)},
                         {"resistance_ohm", converted(r.ohm, 100 * step)}}),
                "")
          << rows << " rows in steps of " << step;
    }
  }
}

TEST(UnclippedColumns, WiresAtRestThermostatsAndSources) {
  const Recording r;
  Columns rest{{"current_A", Values(200, 0.0)},
               {"voltage_V", Values(200, 0.0)},
               {"strain_ref", Values(200, r.strain.front())}};
  Columns hold{{"temperature_degC", {}}, {"strain_ref", {}}};
  for (std::size_t i = 0; i < 200; ++i) {
    rest[0].values.push_back(r.current_A[i]);
    rest[1].values.push_back(r.voltage_V[i]);
    rest[2].values.push_back(r.strain[i]);
    const std::size_t repeat = i == 79 ? 100 : 1;
    hold[0].values.insert(hold[0].values.end(), repeat, r.temperature_degC[i]);
    hold[1].values.insert(hold[1].values.end(), repeat, r.strain[i]);
  }
  identify::RunOptions sampled = of_recorded_wire();
  sampled.trace.period_s = 0.1;
  EXPECT_EQ(refusal(rest, sampled), "");
  EXPECT_EQ(refusal(hold), "");
  // A voltage that has only three levels comes from a source, not from a clipped converter; the
  // current follows the wire's resistance.
  Columns source{{"voltage_V", {}}, {"current_A", {}}, {"strain_ref", r.strain}};
  for (std::size_t i = 0; i < 200; ++i) {
    source[0].values.push_back(i < 40 ? 1 : i < 150 ? 5 : 0.5);
    source[1].values.push_back(source[0].values.back() / r.ohm[i]);
  }
  EXPECT_EQ(refusal(source, sampled), "");
}

TEST(Runs, AllCommittedTracesAreTaken) {
  std::size_t count = 0;
  const std::filesystem::path folder =
      std::filesystem::path(test::source_folder()) / "host-sim" / "traces";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".csv") {
      const auto run = identify::read_run(entry.path().string(), {recorded_wire, {}, {}, {}});
      EXPECT_EQ(run.kind,
                entry.path().stem() == "bath" ? identify::RunKind::bath : identify::RunKind::joule);
      ++count;
    }
  }
  EXPECT_GE(count, 10U);
}

TEST_F(MeasuredData, StaircaseIsSettledAndItsClippedThermometerDoesNotCount) {
  const std::string staircase = file("staircase_even.csv");
  const auto run = identify::read_run(staircase, {{0.225, 300e-6}, 100e6, {}, {}});
  EXPECT_EQ(run.kind, identify::RunKind::settled);
  EXPECT_EQ(run.strain.size(), 41U);
  EXPECT_NEAR(*std::ranges::min_element(run.strain), -(16.920 + 0.008) / 225, 1e-12);
  EXPECT_TRUE(std::isnan(run.resistance_ohm.front()));
}

}  // namespace
}  // namespace smaservo::test
