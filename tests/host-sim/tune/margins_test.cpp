#include "host-sim/tune/linear/margins.hpp"

#include <gtest/gtest.h>
#include <random>

namespace smaservo::tune {
namespace {

using Complex = std::complex<double>;
constexpr double pi = std::numbers::pi;

OpenLoop integrator(double gain, double delay_s) {
  return [=](double w) { return gain * std::polar(1.0, -w * delay_s) / Complex(0, w); };
}

TEST(Margins, OfAnIntegratorWithDelay) {
  for (const double KL : {0.05, 0.2, 0.5, 1.0, 1.4}) {
    const double delay_s = 0.003;
    const Margins m = margins(integrator(KL / delay_s, delay_s), 1e-2, 1e5);
    EXPECT_TRUE(m.stable);
    EXPECT_NEAR(m.gain, pi / (2 * KL), 1e-6 * m.gain);
    EXPECT_NEAR(m.phase_rad, pi / 2 - KL, 1e-6);
    EXPECT_NEAR(m.crossover_rad_s, KL / delay_s, 1e-6 * m.crossover_rad_s);
    EXPECT_NEAR(m.oscillation_rad_s, pi / (2 * delay_s), 1e-6 * m.oscillation_rad_s);
  }
}

TEST(Margins, OfALagWithDelay) {
  const double K = 8, lag_s = 0.5, delay_s = 0.02;
  const Margins m =
      margins([=](double w) { return K * std::polar(1.0, -w * delay_s) / Complex(1, w * lag_s); },
              1e-3, 1e4);
  const double crossover = std::sqrt(K * K - 1) / lag_s;
  EXPECT_TRUE(m.stable);
  EXPECT_NEAR(m.phase_rad, pi - std::atan(crossover * lag_s) - crossover * delay_s, 1e-6);
}

/// Skogestad's rule with the closed-loop time equal to the delay: Ms 1.59, gain margin 3.14, phase
/// margin 61.4° (J. Process Control 13, 2003, table 1).
TEST(Margins, OfSkogestadsRule) {
  const Margins m = margins(integrator(0.5, 1), 1e-4, 1e3);
  EXPECT_NEAR(m.sensitivity, 1.59, 0.005);
  EXPECT_NEAR(m.gain, 3.14, 0.005);
  EXPECT_NEAR(m.phase_rad * 180 / pi, 61.4, 0.05);
}

TEST(Margins, TellWhatIsUnstable) {
  EXPECT_TRUE(margins(integrator(0.99 * pi / 2, 1), 1e-4, 1e3).stable);
  EXPECT_FALSE(margins(integrator(1.01 * pi / 2, 1), 1e-4, 1e3).stable);
  // Three lags of 1 s: stable below a gain of 8.
  const auto lags = [](double K) {
    return [K](double w) { return K / std::pow(Complex(1, w), 3); };
  };
  EXPECT_TRUE(margins(lags(7.9), 1e-4, 1e3).stable);
  EXPECT_FALSE(margins(lags(8.1), 1e-4, 1e3).stable);
  EXPECT_NEAR(margins(lags(4), 1e-4, 1e3).gain, 2, 1e-6);
  // A negative gain that overcomes the lag's own stability.
  EXPECT_TRUE(margins([](double w) { return -0.9 / Complex(1, w); }, 1e-4, 1e3).stable);
  EXPECT_FALSE(margins([](double w) { return -1.1 / Complex(1, w); }, 1e-4, 1e3).stable);
}

/// What Ms guarantees: a gain margin of Ms/(Ms - 1) and a phase margin of 2 arcsin(1/(2 Ms)).
TEST(Margins, AreAtLeastWhatTheSensitivityGuarantees) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  int seen = 0;
  for (int i = 0; i < 300; ++i) {
    const double K = std::pow(10, 3 * uniform(random) - 1);
    const double delay_s = 0.1 * uniform(random), lag_s = uniform(random);
    const double integral_1_s = uniform(random);
    const OpenLoop loop = [=](double w) {
      const Complex s(0, w);
      return K * (1.0 + integral_1_s / s) * std::exp(-s * delay_s) / (1.0 + s * lag_s);
    };
    const Margins m = margins(loop, 1e-4, 1e4);
    if (m.stable) {
      ++seen;
      EXPECT_GE(m.gain, 0.999 * m.sensitivity / (m.sensitivity - 1));
      EXPECT_GE(m.phase_rad, 0.999 * 2 * std::asin(0.5 / m.sensitivity));
    }
  }
  EXPECT_GT(seen, 100);
}

TEST(Margins, TheWorseOfTwoTakesEachNumber) {
  const Margins w = worse({true, 3, 1, 1.5, 10, 20}, {true, 4, 0.8, 1.2, 30, 40});
  EXPECT_EQ(w.gain, 3);
  EXPECT_EQ(w.oscillation_rad_s, 20);
  EXPECT_EQ(w.phase_rad, 0.8);
  EXPECT_EQ(w.crossover_rad_s, 30);
  EXPECT_EQ(w.sensitivity, 1.5);
  EXPECT_FALSE(worse({true, 3, 1, 1.5, 10, 20}, {false, 4, 0.8, 1.2, 30, 40}).stable);
}

}  // namespace
}  // namespace smaservo::tune
