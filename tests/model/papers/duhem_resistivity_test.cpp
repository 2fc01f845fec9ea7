#include "model/papers/duhem_resistivity.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "model/papers/actuators/actuator_file.hpp"
#include "model/units.hpp"

namespace smaservo::duhem_resistivity_test {
namespace {

class DuhemResistivityTest : public testing::Test {
 protected:
  papers::DuhemActuator<double>::Params p =
      papers::load_actuator(std::string(papers::paper_001_actuator));
  const papers::DuhemResistivity<double>& rho = p.resistivity;

  double austenite(double celsius) const {
    return rho.austenite(celsius + zero_degC_K, p.ambient_K);
  }
  double martensite(double celsius) const {
    return rho.martensite(celsius + zero_degC_K, p.ambient_K);
  }
};

TEST_F(DuhemResistivityTest, AustenitesDecaysFromAmbient) {
  EXPECT_NEAR(austenite(24), 1.76e-6, 1e-15);
  EXPECT_NEAR(austenite(100), 9.2e-7, 1e-14);
  EXPECT_NEAR(austenite(30), 9.2e-7 + 8.4e-7 * std::exp(-0.2499 * 6), 1e-15);
}

TEST_F(DuhemResistivityTest, MartensitesIsThePrintedSum) {
  for (double T = 24; T <= 102; T += 3) {
    double sum = (3.4e-8 - 5.7e-10 * T) * (1 + std::erf((T - 70) / 3));
    for (int i = 0; i < 10; ++i) {
      sum += rho.martensite_ohm_m_K[i] * std::pow(T - 24, i);
    }
    EXPECT_NEAR(martensite(T), sum, 1e-12);
  }
}

TEST_F(DuhemResistivityTest, PhasesAreSideBySide) {
  const double T = 60;
  const double K = T + zero_degC_K;
  EXPECT_DOUBLE_EQ(rho.parallel(0, K, p.ambient_K), austenite(T));
  EXPECT_DOUBLE_EQ(rho.parallel(1, K, p.ambient_K), martensite(T));
  EXPECT_NEAR(1 / rho.parallel(0.3, K, p.ambient_K), 0.7 / austenite(T) + 0.3 / martensite(T),
              1e-8 / austenite(T));
}

TEST_F(DuhemResistivityTest, RangeIsThatOfThePolynomial) {
  EXPECT_TRUE(rho.valid(rho.lowest_K));
  EXPECT_TRUE(rho.valid(rho.highest_K));
  EXPECT_FALSE(rho.valid(rho.lowest_K - 0.01));
  EXPECT_FALSE(rho.valid(rho.highest_K + 0.01));
  // Why it has one: 30 K further the polynomial has run away.
  EXPECT_GT(std::abs(martensite(132)), 5e-6);
}

}  // namespace
}  // namespace smaservo::duhem_resistivity_test
