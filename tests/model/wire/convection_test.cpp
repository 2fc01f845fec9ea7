#include "model/wire/convection.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace smaservo::test::convection_test {
namespace {

TEST(SixthRoot, IsTheRoot) {
  double worst = 0;
  double worst_float = 0;
  for (double x = 1e-37; x < 1e37; x *= 1.01) {
    const double exact = std::pow(x, 1.0 / 6);
    ASSERT_TRUE(std::isfinite(sixth_root(x)) && std::isfinite(sixth_root(static_cast<float>(x))));
    worst = std::max(worst, std::abs(sixth_root(x) / exact - 1));
    const auto f = static_cast<float>(x);
    const double of_float = std::pow(static_cast<double>(f), 1.0 / 6);
    worst_float =
        std::max(worst_float, std::abs(static_cast<double>(sixth_root(f)) / of_float - 1));
  }
  EXPECT_LT(worst, 5e-12);
  EXPECT_LT(worst_float, 3e-7);
  EXPECT_GT(sixth_root(0.0), 0);
  EXPECT_LT(sixth_root(0.0), 1e-6);
}

/// Worst relative error against the formula in double, over its whole range.
template <class S>
double worst_error(const ConvectionTable<S>& table) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> kelvin(230, 600);
  std::uniform_real_distribution<double> decade(-5, -3);
  double worst = 0;
  for (int i = 0; i < 200'000; ++i) {
    const auto d = static_cast<S>(std::pow(10, decade(random)));
    const auto ambient = static_cast<S>(kelvin(random));
    // One in four hardly warmer than the air, or not at all
    const double other =
        i % 4 > 0 ? kelvin(random) : static_cast<double>(ambient) + 1e-3 * (i % 8) * (i % 16);
    const auto T = static_cast<S>(other);
    const double exact = natural_convection_W_m2K(static_cast<double>(d), static_cast<double>(T),
                                                  static_cast<double>(ambient));
    const auto h = static_cast<double>(table.h_W_m2K(d, T, ambient));
    worst = std::max(worst, std::abs(h / exact - 1));
  }
  return worst;
}

TEST(ConvectionTable, IsTheFormula) {
  const double in_double = worst_error(ConvectionTable<double>());
  const double in_float = worst_error(ConvectionTable<float>());
  std::printf("worst relative error: double %.1e, float %.1e\n", in_double, in_float);
  EXPECT_LT(in_double, 1e-6);
  EXPECT_LT(in_float, 2e-6);
}

TEST(ConvectionTable, DoesNotJumpBetweenItsCells) {
  const ConvectionTable<double> table;
  const double ambient_K = 300;
  for (double film_K = 240; film_K < 600; film_K += 10) {
    const double T = 2 * film_K - ambient_K;
    const double below = table.h_W_m2K(76e-6, T - 1e-9, ambient_K);
    const double above = table.h_W_m2K(76e-6, T + 1e-9, ambient_K);
    EXPECT_NEAR(below / above, 1, 1e-7) << film_K;
  }
}

TEST(ConvectionTable, StaysDefinedFarOutside) {
  const ConvectionTable<double> table;
  const double h = table.h_W_m2K(76e-6, 1250, 300);
  EXPECT_NEAR(h / natural_convection_W_m2K(76e-6, 1250.0, 300.0), 1, 1e-6);
  EXPECT_TRUE(std::isfinite(table.h_W_m2K(76e-6, 1e4, 300)));
  EXPECT_TRUE(std::isfinite(table.h_W_m2K(76e-6, 1, 2)));
  EXPECT_TRUE(std::isnan(table.h_W_m2K(76e-6, std::numeric_limits<double>::quiet_NaN(), 300)));
}

}  // namespace
}  // namespace smaservo::test::convection_test
