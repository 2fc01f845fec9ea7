#include "host-sim/evaluate/runs/runs.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <tuple>
#include <vector>

#include "host-sim/simulate/simulate.hpp"

namespace smaservo::test {
namespace {

std::vector<simulate::SimulatedRow> rows(const bench::Scenario& scenario) {
  std::vector<simulate::SimulatedRow> all;
  simulate::simulate_rows(scenario, [&](const simulate::SimulatedRow& row) { all.push_back(row); });
  return all;
}

double stroke_of(const std::vector<simulate::SimulatedRow>& run) {
  const auto [low, high] = std::ranges::minmax(run, {}, &simulate::SimulatedRow::strain);
  return high.strain - low.strain;
}

bool same(const std::vector<simulate::SimulatedRow>& a,
          const std::vector<simulate::SimulatedRow>& b) {
  return std::ranges::equal(
      a, b, [](const simulate::SimulatedRow& x, const simulate::SimulatedRow& y) {
        return std::tie(x.time_s, x.current_A, x.voltage_V, x.load_N, x.strain) ==
               std::tie(y.time_s, y.current_A, y.voltage_V, y.load_N, y.strain);
      });
}

using Case = std::tuple<hal::Family, evaluate::Condition, bool>;
class TestRun : public ::testing::TestWithParam<Case> {
 protected:
  static bench::Scenario scenario(std::uint64_t seed) {
    const auto& [family, condition, disturbed] = GetParam();
    return evaluate::test_run(bench::random_unit(family, seed), condition, seed, disturbed);
  }
};

INSTANTIATE_TEST_SUITE_P(Conditions, TestRun,
                         ::testing::Combine(::testing::ValuesIn(hal::families),
                                            ::testing::ValuesIn(evaluate::all_conditions),
                                            ::testing::Bool()),
                         [](const auto& tested) {
                           std::string name{hal::family_name(std::get<0>(tested.param))};
                           name += "_" +
                                   std::string(evaluate::condition_name(std::get<1>(tested.param)));
                           name += std::get<2>(tested.param) ? "_disturbed" : "";
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

TEST_P(TestRun, IsPhysical) {
  const bench::Scenario made = scenario(3);
  const auto& sensors = std::get<bench::JouleScenario>(made.run).sensors;
  const std::vector<simulate::SimulatedRow> run = rows(made);
  const bool coarse = std::get<1>(GetParam()) == evaluate::Condition::coarse;
  EXPECT_GE(run.back().time_s, 40);
  EXPECT_LE(run.back().time_s, 60);
  EXPECT_NEAR(static_cast<double>(run.size()) / (run.back().time_s - run.front().time_s),
              coarse ? 100 : 1000, 1);
  // Where the air is warm and the load light, a part of the wire does not become martensite; a load
  // that swings stretches the wire, too.
  EXPECT_GT(stroke_of(run), std::get<1>(GetParam()) == evaluate::Condition::light ? 0.025 : 0.029);
  EXPECT_LT(stroke_of(run), 0.050);
  for (const simulate::SimulatedRow& row : run) {
    const double ohm = row.voltage_V / row.current_A;
    ASSERT_TRUE(ohm > 17 && ohm < 28) << row.time_s;
    ASSERT_LT(row.current_A, 0.8 * sensors.current_full_scale_A);
    ASSERT_LT(row.voltage_V, 0.9 * sensors.voltage_full_scale_V);
    ASSERT_TRUE(row.load_N > 0.02 && row.load_N < 2.2) << row.time_s;
  }
}

TEST(TestRuns, SeedDecidesEverything) {
  const bench::WireUnit unit = bench::random_unit(hal::Family::sublayers, 1);
  const auto short_run = [&](std::uint64_t seed) {
    bench::Scenario scenario = evaluate::test_run(unit, evaluate::Condition::varying, seed, true);
    std::get<bench::JouleScenario>(scenario.run).drive.resize(2);
    return rows(scenario);
  };
  EXPECT_TRUE(same(short_run(1), short_run(1)));
  EXPECT_FALSE(same(short_run(1), short_run(2)));
}

TEST(TestRuns, DisturbancesAndLoadsFillTheirRanges) {
  const bench::WireUnit unit = bench::random_unit(hal::Family::ihyp, 1);
  double coldest_K = 400, hottest_K = 0, lightest_Pa = 1e9, heaviest_Pa = 0;
  int drifted_up = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const bench::Scenario made =
        evaluate::test_run(unit, evaluate::Condition::constant, seed, true);
    const auto& joule = std::get<bench::JouleScenario>(made.run);
    coldest_K = std::min(coldest_K, joule.ambient_K);
    hottest_K = std::max(hottest_K, joule.ambient_K);
    const double stress_Pa = std::get<hal::ConstantLoad>(joule.load).stress_Pa;
    lightest_Pa = std::min(lightest_Pa, stress_Pa);
    heaviest_Pa = std::max(heaviest_Pa, stress_Pa);
    EXPECT_TRUE(joule.draught >= 0.8 && joule.draught <= 1.2);
    EXPECT_NEAR(std::abs(joule.sensors.resistance_gain - 1), 0.01, 1e-12);
    drifted_up += joule.sensors.resistance_gain > 1 ? 1 : 0;
    const bench::Scenario calm = evaluate::test_run(unit, evaluate::Condition::constant, seed);
    EXPECT_EQ(std::get<bench::JouleScenario>(calm.run).ambient_K, room_K);
    EXPECT_EQ(std::get<bench::JouleScenario>(calm.run).sensors.resistance_gain, 1);
  }
  EXPECT_TRUE(coldest_K > 288.1 && coldest_K < 289.2);
  EXPECT_TRUE(hottest_K > 307.1 && hottest_K < 308.2);
  EXPECT_TRUE(lightest_Pa >= 100e6 && lightest_Pa < 110e6);
  EXPECT_TRUE(heaviest_Pa > 390e6 && heaviest_Pa <= 400e6);
  EXPECT_TRUE(drifted_up > 70 && drifted_up < 130);
}

TEST(TestRuns, UnknownStartIsInTheMiddleOfAMotion) {
  int moving = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    bench::Scenario made = evaluate::test_run(bench::random_unit(hal::Family::ihyp, seed),
                                              evaluate::Condition::unknown_start, seed);
    auto& joule = std::get<bench::JouleScenario>(made.run);
    joule.drive.resize(3);
    const std::vector<simulate::SimulatedRow> run = rows(made);
    EXPECT_EQ(run.front().time_s, 0);
    moving += std::abs(run[300].strain - run[0].strain) > 0.002 ? 1 : 0;
  }
  EXPECT_EQ(moving, 10);
}

TEST(TestRuns, RippleHoldsTheWireInMidTransformation) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const bench::WireUnit unit =
        bench::random_unit(seed % 2 == 0 ? hal::Family::ihyp : hal::Family::sublayers, seed);
    const std::vector<simulate::SimulatedRow> run =
        rows(evaluate::test_run(unit, evaluate::Condition::hold_ripple, seed));
    const auto [low, high] = std::ranges::minmax(run, {}, &simulate::SimulatedRow::strain);
    const double span = high.strain - low.strain;
    // The ripple begins at 13 s. Its third second, and its nineteenth:
    const auto second = [&](std::ptrdiff_t from_s) {
      return std::ranges::subrange(run.begin() + 1000 * from_s, run.begin() + 1000 * (from_s + 1));
    };
    const auto mean = [&](std::ptrdiff_t from_s) {
      double sum = 0;
      for (const simulate::SimulatedRow& row : second(from_s)) {
        sum += (row.strain - low.strain) / span / 1000;
      }
      return sum;
    };
    EXPECT_TRUE(mean(16) > 0.1 && mean(16) < 0.9) << seed << ": " << mean(16);
    // A wire has return-point memory: it settles.
    EXPECT_NEAR(mean(32), mean(16), 0.01) << seed;
    const auto [min, max] = std::ranges::minmax(
        second(20), {},
        [](const simulate::SimulatedRow& row) { return row.current_A * row.voltage_V; });
    EXPECT_NEAR(max.current_A * max.voltage_V / (min.current_A * min.voltage_V), 3, 0.05);
  }
}

TEST(TestRuns, AGustMovesAHeldWire) {
  double least = 1, most = 1;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const bench::WireUnit unit =
        bench::random_unit(seed % 2 == 0 ? hal::Family::ihyp : hal::Family::sublayers, seed);
    const bench::Scenario made = evaluate::test_run(unit, evaluate::Condition::gust, seed);
    const auto& drive = std::get<bench::JouleScenario>(made.run).drive;
    const auto gust =
        std::ranges::find_if(drive, [](const bench::DriveStep& step) { return step.draught != 1; });
    ASSERT_NE(gust, drive.end());
    EXPECT_EQ(gust->level, std::prev(gust)->level);
    EXPECT_EQ(gust->level, std::next(gust)->level);
    least = std::min(least, gust->draught);
    most = std::max(most, gust->draught);
    // It begins at 18 s and ends at 28 s. A wire that is cooled more is longer.
    const std::vector<simulate::SimulatedRow> run = rows(made);
    EXPECT_NEAR(run[17900].strain, run[16900].strain, 2e-4) << seed << ": held";
    EXPECT_EQ(run[27900].strain > run[17900].strain, gust->draught > 1) << seed;
  }
  EXPECT_TRUE(least >= 0.5 && least < 0.8) << least;
  EXPECT_TRUE(most <= 3 && most > 2) << most;
}

TEST(CalibrationRuns, CoverTheStressesForAMinuteFromRestAt25DegC) {
  for (const hal::Family family : hal::families) {
    const bench::WireUnit unit = bench::random_unit(family, 5);
    for (const std::size_t index :
         {std::size_t{0}, evaluate::calibration_stresses_MPa.size() - 1}) {
      const bench::Scenario scenario = evaluate::calibration_run(unit, index);
      const auto& joule = std::get<bench::JouleScenario>(scenario.run);
      EXPECT_EQ(joule.ambient_K, room_K);
      EXPECT_EQ(joule.drive.front().level, 0);
      const std::vector<simulate::SimulatedRow> run = rows(scenario);
      EXPECT_EQ(run.size(), 60000U);
      EXPECT_GT(stroke_of(run), 0.027);
      EXPECT_LT(stroke_of(run), 0.050);
      const double stress_Pa =
          run[500].load_N / unit.wire.wire.geometry.area_m2() / joule.sensors.load_gain;
      EXPECT_NEAR(stress_Pa / 1e6, evaluate::calibration_stresses_MPa.at(index), 2.5);
    }
  }
}

TEST(CalibrationRuns, AreRunsOfTheirOwn) {
  const bench::WireUnit unit = bench::random_unit(hal::Family::ihyp, 5);
  EXPECT_NE(evaluate::calibration_run(unit, 0).seed, evaluate::calibration_run(unit, 1).seed);
  EXPECT_EQ(evaluate::calibration_run(unit, 1).seed, evaluate::calibration_run(unit, 1).seed);
  EXPECT_NE(evaluate::calibration_run(unit, 1).seed,
            evaluate::calibration_run(bench::random_unit(hal::Family::ihyp, 6), 1).seed);
}

}  // namespace
}  // namespace smaservo::test
