#include "model/papers/spring_bias.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "model/papers/actuators/actuator_file.hpp"

namespace smaservo::spring_bias_test {
namespace {

papers::SpringBias<double> table_1() {
  return papers::load_actuator(std::string(papers::paper_001_actuator)).bias;
}

/// Wires and springs of which many detwin, some wholly.
papers::SpringBias<double> any_bias(std::mt19937_64& random) {
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  papers::SpringBias<double> b = table_1();
  b.length_m = uniform(0.05, 0.25);
  b.spring_N_m = uniform(20, 60);
  b.austenite_Pa = uniform(4e8, 4e9);
  b.twinned_Pa = b.austenite_Pa * uniform(0.3, 0.8);
  b.part_twinned_Pa = b.twinned_Pa * uniform(0.02, 0.1);
  b.detwinned_Pa = b.twinned_Pa * uniform(0.5, 0.95);
  b.yield_strain = b.prestrain() * uniform(1.05, 1.8);
  b.detwinned_strain = b.yield_strain + uniform(2e-3, 0.02);
  return b;
}

/// The balance of eq. 15 and eq. 16 by bisection: the oracle.
double bisected(const papers::SpringBias<double>& b, double martensite) {
  double low = 0;
  double high = 0.9;
  for (int i = 0; i < 100; ++i) {
    const double middle = (low + high) / 2;
    (b.wire_stress_Pa(martensite, middle) < b.spring_stress_Pa(middle) ? low : high) = middle;
  }
  return low;
}

TEST(SpringBias, PrestrainBalancesAustenite) {
  const papers::SpringBias<double> b = table_1();
  // 001 eq. 13, both of its sides
  const double stress_Pa = 4 * b.spring_N_m * b.deformation_m /
                           (std::numbers::pi * b.diameter_m * b.diameter_m * (1 - b.prestrain()));
  EXPECT_NEAR(b.austenite_Pa * b.prestrain(), stress_Pa, 1e-6 * stress_Pa);
  EXPECT_DOUBLE_EQ(b.balanced_strain(0), b.prestrain());
}

TEST(SpringBias, StrainBalancesSpringAndPhasesOnAllPieces) {
  std::mt19937_64 random{1};
  int pieces[3] = {};
  for (int i = 0; i < 2000; ++i) {
    const papers::SpringBias<double> b = any_bias(random);
    for (double martensite = 0; martensite <= 1; martensite += 0.05) {
      const double strain = b.balanced_strain(martensite);
      const double spring_Pa = b.spring_stress_Pa(strain);
      ASSERT_NEAR(b.wire_stress_Pa(martensite, strain), spring_Pa, 1e-9 * b.austenite_Pa * strain);
      ASSERT_NEAR(strain, bisected(b, martensite), 1e-12);
      ++pieces[strain < b.yield_strain ? 0 : strain < b.detwinned_strain ? 1 : 2];
    }
  }
  for (const int count : pieces) {
    EXPECT_GT(count, 300);
  }
}

TEST(SpringBias, StrainIsContinuousAtBothLimits) {
  std::mt19937_64 random{2};
  int crossed[2] = {};
  for (int i = 0; i < 500; ++i) {
    const papers::SpringBias<double> b = any_bias(random);
    const double limits[2] = {b.yield_strain, b.detwinned_strain};
    for (const double& limit : limits) {
      if (!(b.balanced_strain(0) < limit && limit < b.balanced_strain(1))) {
        continue;
      }
      double low = 0;
      double high = 1;
      for (int halving = 0; halving < 60; ++halving) {
        const double middle = (low + high) / 2;
        (b.balanced_strain(middle) < limit ? low : high) = middle;
      }
      // The two sides of the limit belong to different pieces.
      ASSERT_LT(b.balanced_strain(low), limit);
      ASSERT_GE(b.balanced_strain(high), limit);
      ASSERT_NEAR(b.balanced_strain(low), b.balanced_strain(high), 1e-11);
      ++crossed[&limit - limits];
    }
  }
  EXPECT_GT(crossed[0], 50);
  EXPECT_GT(crossed[1], 50);
}

TEST(SpringBias, MartensiteStretchesAndRelaxesTheSpring) {
  const papers::SpringBias<double> b = table_1();
  double strain = b.balanced_strain(0);
  for (double martensite = 0.01; martensite <= 1; martensite += 0.01) {
    const double next = b.balanced_strain(martensite);
    EXPECT_GT(next, strain);
    EXPECT_LT(b.spring_stress_Pa(next), b.spring_stress_Pa(strain));
    strain = next;
  }
}

TEST(SpringBias, PolynomialFollowsTheBalance) {
  // 001 figure 11: both curves lie on each other.
  const papers::SpringBias<double> b = table_1();
  double worst = 0;
  for (double martensite = 0; martensite <= 1; martensite += 0.001) {
    const double by_power = b.prestrain() + 0.0204 * martensite +
                            0.01293 * martensite * martensite + 0.0027 * std::pow(martensite, 50);
    ASSERT_NEAR(b.smooth_strain(martensite), by_power, 1e-15);
    worst = std::max(worst, std::abs(by_power - b.balanced_strain(martensite)));
  }
  EXPECT_LT(worst, 3.5e-4);
  EXPECT_GT(worst, 3e-4);  // the header's figure
}

}  // namespace
}  // namespace smaservo::spring_bias_test
