#include "model/wire/heat.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

#include "tests/model/wire/test_wires.hpp"

namespace smaservo::test::heat_test {
namespace {

TEST(NaturalConvection, IsChurchillAndChusForThe76umWire) {
  // science.md section 3: 186 W/m²K at 80 °C in 25 °C; others measured 170 to 210.
  const double h = natural_convection_W_m2K(76e-6, room_K + 55, room_K);
  EXPECT_NEAR(h, 186, 2);
}

TEST(NaturalConvection, GrowsWithTheTemperatureAndFallsWithTheDiameter) {
  double before_d = std::numeric_limits<double>::infinity();
  for (const double d : {25e-6, 76e-6, 150e-6, 250e-6, 510e-6}) {
    double before = 0;
    for (double above = 0; above <= 120; above += 5) {
      const double h = natural_convection_W_m2K(d, room_K + above, room_K);
      ASSERT_TRUE(std::isfinite(h));
      EXPECT_GT(h, before);
      before = h;
    }
    EXPECT_LT(before, before_d);
    before_d = before;
  }
  // Without a difference of temperatures conduction is left: Nu = 0.36
  EXPECT_NEAR(natural_convection_W_m2K(76e-6, room_K, room_K) * 76e-6 / 0.0260, 0.36, 0.005);
}

TEST(NaturalConvection, StillAirIsALineCloseToIt) {
  const auto worst_deviation = [](double diameter_m) {
    const StillAir air = still_air(diameter_m);
    double worst = 0;
    for (double above = 10; above <= 110; above += 1) {
      const double exact = natural_convection_W_m2K(diameter_m, room_K + above, room_K);
      const double line = air.convection_W_m2K + air.convection_W_m2K2 * above;
      worst = std::max(worst, std::abs(line / exact - 1));
    }
    return worst;
  };
  EXPECT_LT(worst_deviation(25e-6), 0.02);
  EXPECT_LT(worst_deviation(76e-6), 0.02);
  EXPECT_LT(worst_deviation(510e-6), 0.041);
  EXPECT_GT(worst_deviation(510e-6), 0.03);  // thick wires bend more
}

TEST(ThermalBody, TimeConstantsAreTheMeasuredOnes) {
  // science.md section 3: rho c d/4h. A Flexinol and a SmartFlex wire of one diameter are alike.
  const auto time_constant_s = [](double diameter_m) {
    HeatParams<double> heat = paper_wire().heat;
    heat.clamp_conductivity_W_mK = 0;
    const StillAir air = still_air(diameter_m);
    heat.convection_W_m2K = air.convection_W_m2K;
    heat.convection_W_m2K2 = air.convection_W_m2K2;
    const ThermalBody<double> body = thermal_body<double>({0.1, diameter_m}, heat);
    return body.capacity_J_K * 55 / body.loss_W(55);
  };
  EXPECT_NEAR(time_constant_s(76e-6), 0.30, 0.01);
  EXPECT_NEAR(time_constant_s(150e-6), 1.0, 0.05);
  EXPECT_NEAR(time_constant_s(250e-6), 2.5, 0.1);
  EXPECT_NEAR(time_constant_s(510e-6), 8.6, 0.3);
}

TEST(ThermalBody, ClampsReach1Point4mmIntoThe76umWire) {
  HeatParams<double> heat = paper_wire().heat;
  EXPECT_NEAR(1e3 * clamp_reach_m(paper_wire().geometry, heat), 1.4, 0.06);
  heat.convection_W_m2K = 186;
  EXPECT_NEAR(1e3 * clamp_reach_m(paper_wire().geometry, heat), 1.36, 0.01);
}

TEST(ThermalBody, ShortWireLosesMoreThroughItsClamps) {
  const HeatParams<double>& heat = paper_wire().heat;
  const double d = 76e-6;
  const auto reach_m = clamp_reach_m<double>({1, d}, heat);
  const auto loss_W_m = [&](double length_m) {
    return thermal_body<double>({length_m, d}, heat).loss_W_K / length_m;
  };
  const double free_W_mK = std::numbers::pi * d * heat.convection_W_m2K;
  EXPECT_NEAR(loss_W_m(0.1), free_W_mK, 1e-9 * free_W_mK);
  // L = 4 λ: the middle of a fin reaches 1 - 1/cosh 2 of the free wire's temperature.
  EXPECT_NEAR(loss_W_m(4 * reach_m), free_W_mK / (1 - 1 / std::cosh(2)), 1e-9 * free_W_mK);
}

TEST(ThermalBody, LossSlopeIsTheDerivativeAndLatentHeatOnlyAdds) {
  const ThermalBody<double> body{1e-3, 0.05, 0.015, 4e-3, 1e-5};
  for (const double above : {-20.0, 0.0, 30.0, 100.0}) {
    const double h = 1e-3;
    EXPECT_NEAR(body.loss_slope_W_K(above),
                (body.loss_W(above + h) - body.loss_W(above - h)) / (2 * h), 1e-12);
  }
  EXPECT_DOUBLE_EQ(body.effective_capacity_J_K({-0.1, 0.0}), 6e-3);
  EXPECT_DOUBLE_EQ(body.effective_capacity_J_K({-0.1, -0.2}), 9e-3);
  EXPECT_DOUBLE_EQ(body.effective_capacity_J_K({0.1, 0.0}), 1e-3);
}

}  // namespace
}  // namespace smaservo::test::heat_test
