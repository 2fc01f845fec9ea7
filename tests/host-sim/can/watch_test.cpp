#include "host-sim/can/watch.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <sstream>
#include <utility>

#include "host-sim/can/positions.hpp"
#include "tests/host-sim/can/can_client.hpp"

namespace smaservo::can {
namespace {

using testing::HasSubstr;

struct CanWatch : CanClient {
  std::string remarks;  ///< of all calls of watched()
  std::string watched(const WatchPlan& plan, bool in_place = false) {
    std::string text;
    watch(
        remote, plan, in_place, [&](const std::string& part) { text += part; },
        [&](const std::string& remark) { remarks += remark; });
    return text;
  }
  /// The header and the numbers of one row.
  std::pair<std::vector<std::string>, std::vector<double>> watched_row(
      const std::vector<std::string>& names, Units units) {
    std::istringstream lines(watched({names, 0.05, 1, "", units}));
    std::pair<std::vector<std::string>, std::vector<double>> row;
    std::string line;
    std::getline(lines, line);
    std::istringstream header(line);
    for (std::string field; std::getline(header, field, ',');) {
      row.first.push_back(field);
    }
    std::getline(lines, line);
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) {
      row.second.push_back(std::stod(field));
    }
    return row;
  }
};

TEST_F(CanWatch, WatchShowsRows) {
  EXPECT_THAT(watched({{"live.wire_temperature_K", "6041"}, 0.05, 3, "live.wire_temperature_K"}),
              testing::AllOf(testing::StartsWith("time_s,live.wire_temperature_K,Statusword\n0.0"),
                             HasSubstr("\n0.10")));
}

// A name without a unit gets that of the choice, one with a unit keeps it, and both say the same
// in SI.
TEST_F(CanWatch, WatchShowsTheChosenUnits) {
  const std::vector<std::string> names{
      "position", "live.wire_temperature", "stress",        "limits.current",
      "strain",   "live.stress_kPa",       "limits.power_W"};
  const auto [bench_names, bench] = watched_row(names, Units::bench);
  EXPECT_THAT(bench_names,
              testing::ElementsAre("time_s", "live.position_um", "live.wire_temperature_degC",
                                   "live.stress_MPa", "limits.current_mA", "live.strain_percent",
                                   "live.stress_kPa", "limits.power_W"));
  const auto [si_names, si] = watched_row(names, Units::si);
  EXPECT_THAT(si_names, testing::ElementsAre("time_s", "live.position_m", "live.wire_temperature_K",
                                             "live.stress_Pa", "limits.current_A", "live.strain",
                                             "live.stress_kPa", "limits.power_W"));
  for (std::size_t i = 1; i < bench_names.size(); ++i) {
    const text::KnownObject object = text::find_object(bench_names[i]);
    const text::KnownObject other = text::find_object(si_names[i]);
    EXPECT_EQ(object.key, other.key);
    const double value = object.unit.to_si(bench[i]);
    const double same = other.unit.to_si(si[i]);
    EXPECT_NEAR(value, same, 1e-3 * std::abs(same) + 1e-5) << bench_names[i];
  }
}

// A set-point is in the unit of its mode. Where that changes, no number stands under a wrong unit.
TEST_F(CanWatch, WatchShowsSetPointsInTheUnitOfTheMode) {
  EXPECT_TRUE(watched({{"setpoint"}, 0.05, 1, ""}).starts_with("time_s,live.setpoint\n"));
  EXPECT_THAT(remarks, HasSubstr("no mode is set (6060h), so its unit is not known"));
  EXPECT_THAT(watched({{"setpoint"}, 0.05, 1, ""}, true),
              HasSubstr("no mode is set (6060h), so its unit is not known"));
  EXPECT_THAT(refusal([&] { watched({{"setpoint_um"}, 0.05, 1, ""}); }),
              HasSubstr("live.setpoint_um: no mode is set (6060h)"));
  run(0.5);
  remote.enable();
  remote.move(700, 5);
  const auto [names, values] = watched_row({"setpoint", "reference"}, Units::bench);
  EXPECT_THAT(names, testing::ElementsAre("time_s", "live.setpoint_um", "live.reference_um"));
  EXPECT_NEAR(values[1], 700, 1);
  // With the unit of a mode in its name it is found where the mode in force has that unit.
  const auto [typed_names, typed] =
      watched_row({"setpoint_um", "live.setpoint_mm", "reference_m"}, Units::si);
  EXPECT_THAT(typed_names, testing::ElementsAre("time_s", "live.setpoint_um", "live.setpoint_mm",
                                                "live.reference_m"));
  EXPECT_NEAR(typed[1], 1e3 * typed[2], 0.01);
  EXPECT_NEAR(typed[1], 700, 1);
  EXPECT_THAT(refusal([&] { watched({{"setpoint_mA"}, 0.05, 1, ""}); }),
              HasSubstr("live.setpoint_mA: the mode in force has another unit: m, mm, um"));
  EXPECT_THAT(watched({{"setpoint"}, 0.05, 1, "", Units::si}), HasSubstr("live.setpoint_m\n"));
  int shown = 0;
  std::string text;
  watch(
      remote, {{"setpoint", "setpoint_mm"}, 0.05, 3, ""}, false,
      [&](const std::string& part) {
        text += part;
        if (++shown == 2) {
          remote.set("6060", "-3");
          run(0.1);
        }
      },
      [&](const std::string& remark) { remarks += remark; });
  EXPECT_THAT(text, testing::EndsWith(",,\n"));
  EXPECT_THAT(text, HasSubstr("time_s,live.setpoint_um,live.setpoint_mm\n"));
  EXPECT_THAT(remarks,
              HasSubstr("live.setpoint_um: empty while the mode has another unit, first at"));
}

// The line is there exactly while a position loop has no gain.
TEST_F(CanWatch, WatchSaysThatThePidDoesNothing) {
  constexpr const char* line = "strain.proportional_W is 0, its default: the model alone drives\n";
  const auto table = [&] { return watched({{"position"}, 0.05, 1, ""}, true); };
  EXPECT_THAT(table(), testing::Not(HasSubstr(line))) << "no mode is set";
  run(0.5);
  remote.enable();
  remote.set_profile_position();
  EXPECT_THAT(table(), HasSubstr(line));
  remote.set("strain.proportional_W", "0.5");
  EXPECT_THAT(table(), testing::Not(HasSubstr(line)));
  remote.set("strain.proportional_W", "0");
  remote.set_mode(-3);
  EXPECT_THAT(table(), testing::Not(HasSubstr(line)));
}

}  // namespace
}  // namespace smaservo::can
