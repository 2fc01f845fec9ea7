#include "host-sim/evaluate/closed_loop/hottest.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "firmware/parameters/parameter_check.hpp"
#include "tests/places.hpp"

namespace smaservo::evaluate {
namespace {

std::vector<CalibratedUnit> hottest_units() {
  return calibrated_units(1, 1000, test::source_folder() + "/tests/golden/evaluate");
}

/// Seed 36 loses two thirds of its cooling while it is off: 9.0 K above, and a fault.
TEST(Hottest, HardlyAboveTheLimitAndTheSameOnAnyNumberOfThreads) {
  const std::vector<CalibratedUnit> units = hottest_units();
  const auto runs = run_hottest(units, 1, 60, 1, [](std::size_t) {});
  int hot = 0;
  int violations = 0;
  for (const HottestRun& run : runs) {
    EXPECT_LE(run.above_limit_K, hottest_far_K) << "seed " << run.seed;
    EXPECT_LE(run.over_s, 4) << "seed " << run.seed;
    violations += run.violates() ? 1 : 0;
    hot += run.above_limit_K > -20 ? 1 : 0;
  }
  EXPECT_LE(violations, 1);
  EXPECT_GE(hot, 5) << "scenarios that never come near the limit prove nothing";
  const auto again = run_hottest(units, 1, 60, 2, [](std::size_t) {});
  EXPECT_EQ(hottest_markdown(again), hottest_markdown(runs));
}

/// The resistance of these wires never decides between two hypotheses about their start.
TEST(Hottest, ASearchThatIsNotDecidedIsNoFault) {
  const std::vector<CalibratedUnit> units = hottest_units();
  for (const std::uint64_t seed : {9003690U, 9009871U}) {
    const HottestRun run = run_hottest(random_scenario(units, seed));
    EXPECT_TRUE(run.harmless()) << seed;
    EXPECT_NE(run.first_cause, Fault::estimate_unsure) << seed;
  }
}

/// The fan stops after the cooling was confirmed. By the file's cooling the wire is then cold, but
/// its resistance stays that of austenite.
TEST(Hottest, AWireThatStaysAusteniteIsTestedAgain) {
  const HottestRun run = run_hottest(random_scenario(hottest_units(), 7000310));
  EXPECT_EQ(run.first_cause, Fault::cooling_lost);
  EXPECT_LT(run.above_limit_K, 0);
}

/// The draught at a time, by the definition of events: the last one in the list that holds counts.
double draught_at(const RandomScenario& s, double time_s) {
  double draught = s.loop.board.surroundings.draught;
  for (const bench::SimEvent& e : s.loop.events) {
    draught = e.draught && e.holds(time_s) ? *e.draught : draught;
  }
  return draught;
}

/// Looked for on a grid of 10 ms.
TEST(RandomScenario, SaysWhenItsCoolingHalvesWithinASecond) {
  const std::vector<CalibratedUnit> units = hottest_units();
  constexpr double grid_s = 0.01;
  constexpr int window = 100;
  int halved = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const RandomScenario s = random_scenario(units, seed);
    std::vector<double> draughts;
    double found_s = std::numeric_limits<double>::infinity();
    for (int i = 0; i * grid_s < 60; ++i) {
      draughts.push_back(draught_at(s, i * grid_s));
      const auto from = draughts.end() - std::min(i + 1, window);
      if (2 * draughts.back() <= *std::max_element(from, draughts.end())) {
        found_s = i * grid_s;
        break;
      }
    }
    if (std::isinf(found_s)) {
      EXPECT_GT(s.halved_s, 60 - 2 * grid_s) << seed << ": " << s.loop.note;
    } else {
      EXPECT_NEAR(s.halved_s, found_s, 2 * grid_s) << seed << ": " << s.loop.note;
      ++halved;
    }
  }
  EXPECT_GT(halved, 10);
  EXPECT_LT(halved, 150);
}

TEST(RandomScenario, IsDrawnFromItsSeedAlone) {
  const std::vector<CalibratedUnit> units = hottest_units();
  const RandomScenario one = random_scenario(units, 7);
  random_scenario(units, 8);
  const RandomScenario same = random_scenario(units, 7);
  EXPECT_EQ(one.loop.note, same.loop.note);
  EXPECT_NE(one.loop.note, random_scenario(units, 8).loop.note);
}

TEST(RandomScenario, DrawsEverythingWithSettingsThatADeviceTakes) {
  const std::vector<CalibratedUnit> units = hottest_units();
  std::array<int, random_air_count> airs{};
  std::array<int, random_trouble_count> troubles{};
  std::array<int, mode_count> modes{};
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const RandomScenario s = random_scenario(units, seed);
    ++airs.at(static_cast<std::size_t>(s.air));
    ++troubles.at(static_cast<std::size_t>(s.trouble));
    ++modes.at(static_cast<std::size_t>(s.mode));
    EXPECT_TRUE(check(s.loop.settings).ok()) << seed;
  }
  EXPECT_GT(std::ranges::min(airs), 10);
  EXPECT_GT(std::ranges::min(troubles), 5);
  EXPECT_EQ(std::ranges::count(modes, 0), 1) << "all but off";
}

}  // namespace
}  // namespace smaservo::evaluate
