// Traces of closed loops, and replays of them.

#include "host-sim/simulate/closed_loop_run.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <gmock/gmock.h>
#include <limits>

#include "firmware/bench/device_replay.hpp"
#include "host-sim/simulate/closed_loop_report.hpp"
#include "tests/firmware/bench/scenario/shipped_scenarios.hpp"
#include "tests/host-sim/replay/replays.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;

class ShippedLog : public ::testing::TestWithParam<std::string> {};

TEST_P(ShippedLog, ReplayedFromItsTextGivesTheSameBits) {
  const TemporaryFolder folder;
  bench::ClosedLoopScenario scenario = shipped_scenario(GetParam());
  scenario.duration_s = std::min(scenario.duration_s, 4.0);
  simulate::run_closed_loop(scenario, {.out = folder / "t.csv", .record = false});
  const bench::DeviceReplayOptions options{
      folder / "t.csv", {}, scenario.settings, folder / "again.csv"};
  const bench::DeviceReplayResult result = bench::replay_device(options);
  EXPECT_NEAR(static_cast<double>(result.rows), 1e3 * scenario.duration_s, 1);
  EXPECT_EQ(result.compared.size(), 21U);
  EXPECT_EQ(result.differing_rows, 0U) << summary(options, result);
  EXPECT_TRUE(file_text(folder / "t.csv") == file_text(folder / "again.csv"))
      << "readings and commands survive as well";
}

INSTANTIATE_TEST_SUITE_P(Shipped, ShippedLog, ::testing::ValuesIn(scenario_names()), suffix);

/// A short run with its trace.
class Recorded {
 public:
  Recorded() : scenario_(shipped_scenario("steps")) {
    scenario_.duration_s = 1;
    simulate::run_closed_loop(scenario_, {.out = folder_ / "t.csv", .record = false});
    lines_ = lines_of(file_text(folder_ / "t.csv"));
  }
  std::vector<std::string>& lines() { return lines_; }
  /// The position of a column.
  std::size_t column(const std::string& name) const {
    const std::string before = lines_.front().substr(0, ("," + lines_.front()).find("," + name));
    return static_cast<std::size_t>(std::ranges::count(before, ','));
  }
  std::string field(std::size_t row, const std::string& column_name) const {
    const auto [from, size] = place(row, column_name);
    return lines_.at(row).substr(from, size);
  }
  void edit(std::size_t row, const std::string& column_name, const std::string& text) {
    const auto [from, size] = place(row, column_name);
    lines_.at(row).replace(from, size, text);
  }
  bench::DeviceReplayResult replay(double tolerance = 0) {
    return bench::replay_device(
        {folder_.write("edited.csv", joined(lines_)), {}, scenario_.settings, "", tolerance});
  }
  std::string refusal() {
    try {
      replay();
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "was accepted";
  }

 private:
  /// Where a field's text begins, and its length.
  std::pair<std::size_t, std::size_t> place(std::size_t row, const std::string& column_name) const {
    const std::string& line = lines_.at(row);
    std::size_t from = 0;
    for (std::size_t i = column(column_name); i > 0; --i) {
      from = line.find(',', from) + 1;
    }
    return {from, line.find(',', from) - from};
  }

  TemporaryFolder folder_;
  bench::ClosedLoopScenario scenario_;
  std::vector<std::string> lines_;
};

TEST(DeviceReplay, FormerNamesOfColumnsAreTakenAndSaid) {
  Recorded run;
  std::string& header = run.lines().front();
  for (const auto& [now, former] : {std::pair{"wire_temperature_K", "wire_K"},
                                    {"estimated_ambient_K", "believed_ambient_K"},
                                    {"wanted_power_W", "power_W"}}) {
    header.replace(header.find(now), std::string_view(now).size(), former);
  }
  const bench::DeviceReplayResult result = run.replay();
  EXPECT_EQ(result.compared.size(), 21U);
  EXPECT_EQ(result.differing_rows, 0U);
  EXPECT_THAT(result.renamed, ::testing::UnorderedElementsAre(
                                  "wire_K is now called wire_temperature_K",
                                  "believed_ambient_K is now called estimated_ambient_K",
                                  "power_W is now called wanted_power_W"));
}

TEST(DeviceReplay, FindsAnOutputThatWasChanged) {
  Recorded run;
  run.edit(501, "drive_current_A", "0.25");
  run.edit(700, "state", "asleep");
  const bench::DeviceReplayResult result = run.replay();
  EXPECT_EQ(result.differing_rows, 2U);
  ASSERT_EQ(result.differences.size(), 2U);
  EXPECT_EQ(result.differences[0].column, "drive_current_A");
  EXPECT_EQ(result.differences[0].rows, 1U);
  EXPECT_NEAR(result.differences[0].first_s, 0.5, 1e-9);
  EXPECT_EQ(result.differences[0].recorded, "0.25");
  EXPECT_GT(result.differences[0].max, 0);
  EXPECT_EQ(result.differences[1].recorded, "asleep");
}

TEST(DeviceReplay, ToleratesAShareOfAnOutputsRange) {
  Recorded run;
  double min = std::numeric_limits<double>::infinity();
  double max = -min;
  for (std::size_t row = 1; row < run.lines().size(); ++row) {
    const double value = std::stod(run.field(row, "drive_current_A"));
    min = std::min(min, value);
    max = std::max(max, value);
  }
  ASSERT_GT(max, min);
  const double middle = (min + max) / 2;
  const std::size_t nearest = 800;
  const double before = std::stod(run.field(nearest, "drive_current_A"));
  const double change = (before < middle ? 0.01 : -0.01) * (max - min);
  run.edit(nearest, "drive_current_A", fmt::format("{}", before + change));
  EXPECT_TRUE(bench::agrees(run.replay(0.010001)));
  EXPECT_FALSE(bench::agrees(run.replay(0.009999)));
  EXPECT_FALSE(bench::agrees(run.replay()));
}

TEST(DeviceReplay, ToleratesNoOtherTextAndNoMissingNumber) {
  EXPECT_TRUE(bench::agrees(Recorded().replay(1)));
  for (const auto& [column, text] : {std::pair{"state", "asleep"},
                                     {"latched_faults", "wire_open"},
                                     {"strain", ""},
                                     {"strain", "nan"},
                                     {"strain", "0.01x"}}) {
    Recorded run;
    run.edit(700, column, text);
    EXPECT_FALSE(bench::agrees(run.replay(1))) << column << ' ' << text;
  }
}

TEST(DeviceReplay, AnInputThatWasChangedChangesTheOutputs) {
  Recorded run;
  run.edit(800, "current_A", "0.1234");
  EXPECT_GT(run.replay().differing_rows, 50U);
}

TEST(DeviceReplay, WhatTheCallerKnewIsInTheLog) {
  Recorded run;
  for (std::size_t row = 601; row < run.lines().size(); ++row) {
    run.edit(row, "external_faults", "bus_lost");
  }
  const bench::DeviceReplayResult result = run.replay();
  ASSERT_FALSE(result.differences.empty());
  for (const bench::OutputDifference& difference : result.differences) {
    EXPECT_GE(difference.first_s, 0.6) << difference.column;
  }
}

TEST(DeviceReplay, NeedsTheCommandsAndSmallSteps) {
  {
    Recorded run;
    std::string& header = run.lines().front();
    header.replace(header.find("command_setpoint"), 16, "wish");
    EXPECT_THAT(run.refusal(), HasSubstr("has no column command_setpoint"));
  }
  {
    Recorded run;
    run.edit(10, "command_mode", "dance");
    EXPECT_THAT(run.refusal(), HasSubstr("command_mode = 'dance' is no mode"));
  }
  {
    Recorded run;
    run.edit(10, "command_setpoint", "1e");
    EXPECT_THAT(run.refusal(), HasSubstr("is not a finite number"));
  }
  {
    Recorded run;
    run.edit(10, "external_faults", "wire_bent");
    EXPECT_THAT(run.refusal(), HasSubstr("external_faults = 'wire_bent'"));
  }
  Recorded run;
  run.lines().erase(run.lines().begin() + 100, run.lines().begin() + 200);
  EXPECT_THAT(run.refusal(), HasSubstr("a device steps every 0.0001 to 0.02 s"));
}

// Longer steps are those after a stall; what follows is the device's own.
TEST(DeviceReplay, StepsOverAStallThatTheLogTells) {
  Recorded run;
  run.edit(800, "external_faults", "loop_stalled");
  run.lines().erase(run.lines().begin() + 700, run.lines().begin() + 800);
  const bench::DeviceReplayResult result = run.replay();
  const auto latched =
      std::ranges::find(result.differences, "latched_faults", &bench::OutputDifference::column);
  ASSERT_NE(latched, result.differences.end());
  EXPECT_EQ(latched->now, "loop_stalled");
}

TEST(ClosedLoop, SameScenarioSameTrace) {
  const TemporaryFolder folder;
  bench::ClosedLoopScenario scenario = shipped_scenario("pair");
  scenario.duration_s = 0.8;
  for (const char* name : {"a.csv", "b.csv"}) {
    simulate::run_closed_loop(scenario, {.out = folder / name, .record = false});
  }
  EXPECT_TRUE(file_text(folder / "a.csv") == file_text(folder / "b.csv"));
}

TEST(ClosedLoop, TheReportShowsStepsAndTemperatures) {
  const TemporaryFolder folder;
  bench::ClosedLoopScenario scenario = shipped_scenario("steps");
  scenario.duration_s = 3;
  const simulate::LoopRunResult result =
      simulate::run_closed_loop(scenario, {.out = "", .record = true});
  ASSERT_FALSE(result.strain_steps.empty());
  simulate::write_report(folder / "r.html", scenario, result, Units::bench);
  const std::string html = file_text(folder / "r.html");
  for (const char* part : {"Strain", "Temperature", "States, limits, faults", "overshoot",
                           "hottest point, true", "sublayers"}) {
    EXPECT_THAT(html, HasSubstr(part));
  }
  EXPECT_EQ(html.find("http://"), std::string::npos) << "it opens without a network";
}

std::string remarks_of(const std::function<void(bench::ClosedLoopScenario&)>& change) {
  bench::ClosedLoopScenario scenario = shipped_scenario("steps");
  scenario.duration_s = 2.4;
  change(scenario);
  const auto result = simulate::run_closed_loop(scenario, {.out = "", .record = false});
  EXPECT_GE(result.strain_steps.size(), 1U);
  std::string all;
  for (const std::string& remark : simulate::unreached(scenario, result)) {
    all += remark + '\n';
  }
  EXPECT_THAT(simulate::summary(scenario, result), HasSubstr(all));
  return all;
}

TEST(Unreached, SaysNothingOfStepsThatAreReached) {
  EXPECT_EQ(remarks_of([](auto&) {}), "");
}

TEST(Unreached, NamesTheLimitThatHoldsTheWireAndItsValue) {
  EXPECT_THAT(remarks_of([](auto& s) { s.settings.limits.current_A = 0.1; }),
              HasSubstr(" by\n  limits.current_A, 100 mA\n"));
  EXPECT_THAT(remarks_of([](auto& s) { s.settings.limits.power_W = 0.1; }),
              HasSubstr(" by\n  limits.power_W, 0.1 W\n"));
  EXPECT_THAT(
      remarks_of([](auto& s) { s.settings.limits.temperature_K = 345; }),
      HasSubstr(" by\n  53.85 °C: limits.temperature_degC, 71.85, less limits.hot_spot_K, 18"));
  EXPECT_THAT(remarks_of([](auto& s) { s.settings.limits.min_strain = 0.035; }),
              HasSubstr("set-point held at 3.500 % by\n  limits.min_strain, 3.5 %\n"));
}

TEST(Unreached, NamesTheFaultThatEndedTheStep) {
  bench::ClosedLoopScenario scenario = shipped_scenario("wire-break");
  scenario.duration_s = 3.2;
  const auto result = simulate::run_closed_loop(scenario, {.out = "", .record = false});
  EXPECT_THAT(simulate::unreached(scenario, result),
              ::testing::ElementsAre(HasSubstr(": ended by wire_open;\n")));
}

}  // namespace
}  // namespace smaservo::test
