// Measured wires, replayed with parameters that were never fitted to them. The bounds say how far
// off an uncalibrated model is, 30 % to both sides; they are no target.

#include "tests/host-sim/replay/measured_data.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include "tests/host-sim/replay/replays.hpp"

namespace smaservo::test {
namespace {

void expect_near(double value, double expected, const char* what) {
  EXPECT_GT(value, 0.7 * expected) << what;
  EXPECT_LT(value, 1.3 * expected) << what;
}

void expect_about(const replay::ErrorStatistics& error, double mean, double p95, double maximum) {
  expect_near(error.mean(), mean, "mean");
  expect_near(error.quantile(0.95), p95, "95 %");
  expect_near(error.maximum(), maximum, "maximum");
}

void expect_physical(const Estimated& e) {
  const auto [coldest, hottest] = std::ranges::minmax(e.column("wire_temperature_degC"));
  EXPECT_GT(coldest, 0) << "nothing cools the wire below the room";
  EXPECT_LT(hottest, 277) << "where the observer stops believing";
  for (const char* phase : {"martensite", "r_phase", "austenite"}) {
    const auto [min, max] = std::ranges::minmax(e.column(phase));
    EXPECT_GE(min, -1e-5) << phase;
    EXPECT_LE(max, 1 + 1e-5) << phase;
  }
}

struct Flexinol {
  const char* file;
  double lt_mean, lt_p95, lt_max;
  double ht_mean, ht_p95, ht_max;
};

TEST_F(MeasuredData, FlexinolCyclesRunThroughTheModelAlone) {
  // Full heating and cooling in a bath. Transition temperatures of the maker's table are some ten
  // kelvin off, which is half the stroke on the steep flanks. LT is the nearer of the two alloys.
  constexpr Flexinol cycles[] = {
      {"flexinol_50MPa.csv", 10.67, 35.83, 47.86, 14.05, 56.42, 60.83},
      {"flexinol_100MPa.csv", 12.35, 41.61, 53.93, 15.45, 59.61, 63.30},
      {"flexinol_200MPa.csv", 11.96, 31.21, 50.50, 16.63, 64.70, 71.65},
  };
  for (const Flexinol& cycle : cycles) {
    SCOPED_TRACE(cycle.file);
    replay::ReplayOptions options;
    options.trace = file(cycle.file);
    options.wire = files::load_wire("flexinol-lt-0.15mm");
    const Estimated lt = estimated(options);
    EXPECT_TRUE(lt.result.open_loop);
    EXPECT_EQ(lt.result.rows, 499U);
    EXPECT_EQ(lt.result.skipped, 0U);
    expect_physical(lt);
    expect_about(lt.result.observers.front().error, cycle.lt_mean, cycle.lt_p95, cycle.lt_max);
    options.wire = files::load_wire("flexinol-ht-0.15mm");
    const Estimated ht = estimated(options);
    expect_about(ht.result.observers.front().error, cycle.ht_mean, cycle.ht_p95, cycle.ht_max);
    EXPECT_LT(lt.result.observers.front().error.mean(), ht.result.observers.front().error.mean());
  }
}

/// The staircase's settled states, 10 s each. Nobody noted the wire.
replay::ReplayOptions staircase(const std::string& file, const char* preset,
                                const std::vector<files::Override>& settings) {
  replay::ReplayOptions options;
  options.trace = file;
  options.trace_options.renames = {"time_s=step*5"};
  options.wire = files::load_wire(preset, settings);
  options.observers = {"kalman", "open-loop", "line"};
  return options;
}

TEST_F(MeasuredData, StaircaseOfAPlausibleWire) {
  // 3.46 ohm cold, and transformed by 0.55 A in still air: 300 um and 225 mm. 4 % of that are
  // 9.0 mm, not the 16.9 mm of the column, so a lever must have been between.
  replay::ReplayOptions options =
      staircase(file("staircase_even.csv"), "smartflex-300um", {{"wire.length_mm", "225"}});
  options.trace_options.renames.emplace_back("displacement_mm=displacement_mm*0.533");
  options.stress_Pa = 100e6;
  const Estimated e = estimated(options);
  EXPECT_EQ(e.result.rows, 41U);
  EXPECT_EQ(e.result.invalid, 1U) << "the first state has no current";
  EXPECT_EQ(e.result.restarts, 0U);
  EXPECT_DOUBLE_EQ(e.result.duration_s, 400);
  ASSERT_TRUE(e.result.has_reference);
  expect_physical(e);
  const auto& observers = e.result.observers;
  // Hot, this wire's resistance is 1 % below what the model allows. The filter contradicts it, says
  // so and searches again, every few seconds; a row may fall into a search, so there is no maximum.
  expect_near(observers[0].error.mean(), 6.74, "mean");
  expect_near(observers[0].error.quantile(0.95), 20, "95 %");
  expect_about(observers[1].error, 9.38, 21.40, 49.27);
  expect_about(observers[2].error, 8.30, 28.01, 39.90);
}

TEST_F(MeasuredData, AWrongGuessOfTheWireStaysPhysical) {
  // 400 um and 400 mm have the same resistance and the stroke of the column, but lose three times
  // the heat, so power and resistance contradict each other.
  replay::ReplayOptions options =
      staircase(file("staircase_even.csv"), "smartflex-400um", {{"wire.length_mm", "400"}});
  options.stress_Pa = 170e6;
  expect_physical(estimated(options));
}

}  // namespace
}  // namespace smaservo::test
