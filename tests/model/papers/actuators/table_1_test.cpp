// Table I of paper 001 and what its text says about it.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "model/papers/actuators/actuator_file.hpp"
#include "model/units.hpp"

namespace smaservo::papers {
namespace {

using Model = DuhemActuator<double>;

Model::Params table_1() {
  return load_actuator(std::string(paper_001_actuator));
}

/// With the moduli as they are printed.
SpringBias<double> printed_moduli() {
  SpringBias<double> b = table_1().bias;
  for (double* modulus : {&b.austenite_Pa, &b.twinned_Pa, &b.part_twinned_Pa, &b.detwinned_Pa}) {
    *modulus *= 100;
  }
  return b;
}

constexpr double printed_alpha[10] = {8.7e-7,  4.8e-8,   -7.8e-9, 7.0e-10,  -3.7e-11,
                                      1.2e-12, -2.5e-14, 3.2e-16, -2.2e-18, 6.7e-21};

TEST(Table1, StrainStaysBelowWhatTheTextSays) {
  // Section II: 'the value of ε does not exceed 0.105'; section IV: ε < ε_m^d always.
  const SpringBias<double> b = table_1().bias;
  EXPECT_LT(b.balanced_strain(1), 0.105);
  EXPECT_LT(b.smooth_strain(1), 0.105);
  EXPECT_GT(b.balanced_strain(1), b.yield_strain);
}

TEST(Table1, StressVariesByFourMegapascals) {
  // Section III: 'merely 4 MPa'.
  const SpringBias<double> b = table_1().bias;
  const double varies_MPa =
      (b.spring_stress_Pa(b.balanced_strain(0)) - b.spring_stress_Pa(b.balanced_strain(1))) / 1e6;
  EXPECT_NEAR(varies_MPa, 4, 0.5);
}

TEST(Table1, PrintedModuliContradictTheText) {
  const SpringBias<double> b = printed_moduli();
  EXPECT_NEAR(b.austenite_Pa, 35917e6, 1);
  const double stroke = b.balanced_strain(1) - b.balanced_strain(0);
  EXPECT_NEAR(stroke, 0.00047, 1e-5);
  // Figure 11 shows it on eq. 18, which says 0.036.
  EXPECT_NEAR(b.smooth_strain(1) - b.smooth_strain(0), 0.036, 1e-4);
  EXPECT_LT(b.spring_stress_Pa(b.balanced_strain(0)) - b.spring_stress_Pa(b.balanced_strain(1)),
            0.05e6);
}

TEST(Table1, CoefficientsRoundToThePrintedOnes) {
  const Model::Params p = table_1();
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(fmt::format("{:.1e}", p.resistivity.martensite_ohm_m_K[i]),
              fmt::format("{:.1e}", printed_alpha[i]));
  }
}

TEST(Table1, PrintedCoefficientsCannotBeMeant) {
  Model::Params p = table_1();
  const auto at = [&](double celsius) {
    return p.resistivity.martensite(celsius + zero_degC_K, p.ambient_K);
  };
  // NiTi: near 1 µΩm in either phase.
  for (double T = 24; T <= 102; T += 1) {
    EXPECT_GT(at(T), 0.85e-6) << T;
    EXPECT_LT(at(T), 1.1e-6) << T;
  }
  std::ranges::copy(printed_alpha, p.resistivity.martensite_ohm_m_K);
  EXPECT_NEAR(at(40), 1.0e-6, 0.01e-6);
  EXPECT_NEAR(at(80), 4.2e-6, 0.1e-6);
  EXPECT_NEAR(at(100), 62e-6, 1e-6);
  // And what half a unit of their last digit makes of it.
  double uncertain = 0;
  for (int i = 0; i < 10; ++i) {
    const double unit = std::pow(10, std::floor(std::log10(std::abs(printed_alpha[i]))) - 1);
    uncertain += unit / 2 * std::pow(80 - 24, i);
  }
  EXPECT_NEAR(uncertain, 63e-6, 1e-6);
}

TEST(Table1, AmbientTemperatureIsTooWarmForTheWholeLoop) {
  // Fig. 9 begins at R_m = 1, but by μ_- and σ_- a wire cooled to 24 °C does not come back to it.
  const Model::Params p = table_1();
  const auto cooled = Duhem<double>::rest(p.kinetics, {p.ambient_K, 0});
  EXPECT_NEAR(cooled.martensite, 0.958, 0.001);
  EXPECT_EQ(Model::rest(p).kinetics.martensite, 1);
}

}  // namespace
}  // namespace smaservo::papers
