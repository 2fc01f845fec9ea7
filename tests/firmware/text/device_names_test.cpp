#include "firmware/text/device_names.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <random>
#include <set>

#include "firmware/signals.hpp"
#include "firmware/text/canopen/objects.hpp"
#include "firmware/text/device_trace.hpp"
#include "firmware/text/signal_names.hpp"
#include "model/files/error.hpp"

namespace smaservo::text {
namespace {

TEST(DeviceNames, SetsOfFaultsComeBack) {
  constexpr std::uint64_t all = (std::uint64_t{1} << static_cast<unsigned>(Fault::count)) - 2;
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t some = random();
    const FaultSet faults = FaultSet::from_bits(some & random() & all);
    EXPECT_EQ(named_faults(names_of(faults)), faults) << names_of(faults);
  }
  EXPECT_EQ(names_of({}), "");
  EXPECT_EQ(named_faults(""), FaultSet{});
}

TEST(DeviceNames, OtherTextsAreNoFaults) {
  for (const char* text : {"none", "wire", "+", "wire_open,wire_short", " wire_open"}) {
    EXPECT_FALSE(named_faults(text)) << text;
  }
}

TEST(DeviceNames, ModesComeBackAndDiffer) {
  std::set<std::string_view> names;
  for (std::uint8_t i = 0; i < mode_count; ++i) {
    const auto mode = static_cast<Mode>(i);
    EXPECT_EQ(mode_of(mode_name(mode)), mode);
    names.insert(mode_name(mode));
  }
  EXPECT_EQ(names.size(), mode_count);
  EXPECT_FALSE(mode_of("Strain"));
}

TEST(DeviceNames, EveryLimitReasonHasOne) {
  std::set<std::string> names;
  for (unsigned i = 0; i < static_cast<unsigned>(LimitReason::count); ++i) {
    names.insert(limit_reason_names(1U << i));
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(LimitReason::count));
  EXPECT_EQ(names.count(""), 0U);
  EXPECT_EQ(limit_reason_names(3), "min_current+current");
}

/// A column of the log that has the name of a signal has that signal's value.
TEST(Signals, HaveTheirValuesInLogs) {
  Cycle cycle{};
  Output<double>& out = cycle.output;
  Inputs<double>& in = cycle.inputs;
  double next = 1;
  for (double* const value :
       {&out.drive_current_A, &out.drive_voltage_V, &out.setpoint, &out.reference,
        &out.wanted_power_W, &out.estimated_ambient_K, &out.hot_spot_K, &out.estimate.strain,
        &out.estimate.strain_sd, &out.estimate.temperature_K, &out.estimate.martensite,
        &out.estimate.r_phase, &out.measurement.power_W, &in.sample.current_A, &in.sample.voltage_V,
        &in.supply_V, &in.ambient_K, &in.driver_K}) {
    *value = next++;
  }
  std::set<std::string_view> names;
  std::vector<DeviceColumn> columns = log_columns(true, true, true);
  columns.insert(columns.end(), output_columns().begin(), output_columns().end());
  std::size_t shared = 0;
  for (const DeviceColumn& column : columns) {
    EXPECT_TRUE(names.insert(column.name).second) << column.name;
    const auto* const signal =
        std::ranges::find(signal_rows<double>, column.name, &Signal<double>::name);
    if (signal != signal_rows<double>.end() && !column.is_text) {
      std::string said;
      column.write(said, cycle);
      EXPECT_EQ(said, fmt::format("{}", signal->read({out, in, {}}))) << column.name;
      ++shared;
    }
  }
  EXPECT_EQ(shared, 15U);
}

TEST(Signals, UnderFormerNamesAreRefusedWithTheNewOnes) {
  for (const char* const former : {"measured_A", "measured_V", "temperature_K", "ambient_K"}) {
    const std::string now(renamed_signal(former));
    EXPECT_EQ(signal_rows<double>.at(signal_row(now)).name, now);
    try {
      signal_row(former);
      ADD_FAILURE() << former;
    } catch (const files::UserError& error) {
      EXPECT_EQ(error.what(), fmt::format("{}: is now called {}", former, now));
    }
    try {
      find_object(fmt::format("live.{}", former));
      ADD_FAILURE() << former;
    } catch (const files::UserError& error) {
      EXPECT_EQ(error.what(), fmt::format("live.{}: is now called live.{}", former, now));
    }
  }
  EXPECT_EQ(renamed_signal("power_W"), "");
}

}  // namespace
}  // namespace smaservo::text
