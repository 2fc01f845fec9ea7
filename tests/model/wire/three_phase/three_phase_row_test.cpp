#include "model/wire/three_phase/three_phase_row.hpp"

#include <gtest/gtest.h>
#include <random>

#include "tests/model/wire/test_wires.hpp"

namespace smaservo::test::three_phase_row_test {
namespace {

using K = ThreePhase<double>;
constexpr std::size_t count = 8;
using Together = Row<K, count>;

/// Eight wires, half of them with processes apart, half without memory.
std::array<K::Params, count> different_wires() {
  std::array<K::Params, count> all;
  for (std::size_t i = 0; i < count; ++i) {
    all[i] = i % 2 == 0 ? separate_kinetics() : paper_wire().kinetics;
    all[i].memory = i % 4 < 2 ? Memory::return_point : Memory::plain;
    all[i].smallest_reversal_K = i < 4 ? 0 : 0.05;
    all[i].loop_odds = i % 3 == 0 ? 8 : 1;
    all[i].m2a.taper = i % 3 == 1 ? 0.5 : 0;
    all[i].m2a.start_K[0] += static_cast<double>(i);
  }
  return all;
}

void expect_same(const K::State& a, const K::State& b) {
  ASSERT_EQ(a.heading, b.heading);
  ASSERT_EQ(a.martensite, b.martensite);
  ASSERT_EQ(a.r_phase, b.r_phase);
  ASSERT_EQ(a.reached.temperature_K, b.reached.temperature_K);
  ASSERT_EQ(a.reached.stress_Pa, b.reached.stress_Pa);
  ASSERT_EQ(a.hot.size(), b.hot.size());
  ASSERT_EQ(a.cold.size(), b.cold.size());
}

/// Which way each will go, as a plant guesses it; sometimes wrong.
std::array<Heading, count> guesses(std::mt19937_64& random) {
  std::array<Heading, count> all;
  for (Heading& heading : all) {
    heading = random() % 2 == 0 ? Heading::heating : Heading::cooling;
  }
  return all;
}

TEST(ThreePhaseRow, EachIsWhatItWouldBeAloneToTheBit) {
  const auto params = different_wires();
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::array<K::State, count> alone;
  for (std::size_t i = 0; i < count; ++i) {
    alone[i] = K::rest(params[i], {300, 150 * MPa});
  }
  std::array<K::State, count> row = alone;
  Together::Kept kept{};
  std::array<double, count> goal_K, temperature_K;
  temperature_K.fill(300);
  double stress_Pa = 150 * MPa;
  int moving = 0;
  for (int step = 0; step < 20000; ++step) {
    for (std::size_t i = 0; i < count; ++i) {
      goal_K[i] = step % 40 == 0 ? 300 + 80 * uniform(random) : goal_K[i];
      temperature_K[i] += 0.1 * (goal_K[i] - temperature_K[i]) + 0.02 * (uniform(random) - 0.5);
    }
    // It stays, it is noisy, it jumps.
    if (step % 1000 > 500) {
      stress_Pa += 1 * MPa * (uniform(random) - 0.5);
    } else if (step % 1000 == 500) {
      stress_Pa = (20 + 300 * uniform(random)) * MPa;
    }
    const auto headings = guesses(random);
    const auto rates = Together::rates(params, row, kept, headings);
    Together::advance(params, row, kept, temperature_K, stress_Pa);
    for (std::size_t i = 0; i < count; ++i) {
      const auto expected = K::rates(params[i], alone[i], headings[i]);
      ASSERT_EQ(rates[i].martensite_1_K, expected.martensite_1_K) << step;
      ASSERT_EQ(rates[i].r_phase_1_K, expected.r_phase_1_K) << step;
      moving += expected.martensite_1_K < 0 ? 1 : 0;
      K::advance(params[i], alone[i], {temperature_K[i], stress_Pa});
      ASSERT_NO_FATAL_FAILURE(expect_same(row[i], alone[i])) << step;
    }
  }
  EXPECT_GT(moving, 10000);
}

}  // namespace
}  // namespace smaservo::test::three_phase_row_test
