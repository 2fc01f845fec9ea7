#include "firmware/text/device_names.hpp"

#include <gtest/gtest.h>
#include <random>
#include <set>

#include "firmware/signals.hpp"
#include "firmware/text/device_trace.hpp"

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

TEST(Signals, WithANameInTracesAreColumns) {
  std::set<std::string_view> columns;
  for (const DeviceColumn& column : log_columns(true, true, true)) {
    columns.insert(column.name);
  }
  for (const DeviceColumn& column : output_columns()) {
    EXPECT_TRUE(columns.insert(column.name).second) << column.name;
  }
  std::set<std::string_view> traced{""};
  for (const Signal<double>& signal : signal_rows<double>) {
    EXPECT_TRUE(signal.trace.empty() || traced.insert(signal.trace).second) << signal.trace;
    EXPECT_TRUE(signal.trace.empty() || columns.contains(signal.trace)) << signal.trace;
  }
}

}  // namespace
}  // namespace smaservo::text
