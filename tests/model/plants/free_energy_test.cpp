// The plant with rates: what it does in time, against the formulas of its head.

#include "model/plants/free_energy.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace smaservo::test::free_energy_test {
namespace {

using K = FreeEnergy<double>;

/// About what the 76 um wire's surfaces give.
constexpr FreeEnergySpread spread{{347, 5.8, 3.2, 0.13e-6, 0},
                                  {313, 8, 3, 0.15e-6, -2.5e-17},
                                  {338, 8, 6, 0.01e-6, 0},
                                  {334, 8, 6, 0.01e-6, 0},
                                  -0.5,
                                  1.5,
                                  1e-3,
                                  4};

/// All parts alike, without neighbours and R-phase.
FreeEnergySpread one_part() {
  FreeEnergySpread s = spread;
  for (ThresholdSpread* process : {&s.m2a, &s.a2m, &s.r2a, &s.a2r}) {
    process->below_K = process->above_K = 1e-9;
  }
  s.a2r.median_K = s.r2a.median_K = 100;
  s.coupling_K = 0;
  return s;
}

/// Where half has become austenite, heated at this rate.
double half_K(const FreeEnergySpread& of, double K_s) {
  const K::Params p = K::params(of);
  K::State s = K::rest(p, {270, 0});
  const double dt_s = 0.01 / K_s;
  double T = 270;
  while (0.5 < K::phases(s).martensite && T < 450) {
    T += 0.01;
    K::advance(p, s, {T, 0}, dt_s);
  }
  return T;
}

TEST(FreeEnergy, StaysOnTheSimplexWhateverHappens) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  const K::Params p = K::params(spread);
  K::State s = K::rest(p, {300, 0});
  for (int i = 0; i < 100000; ++i) {
    const Drive<double> u{250 + 200 * uniform(random), 4e8 * uniform(random)};
    K::advance(p, s, u, std::pow(10, -6 * uniform(random)));
    for (std::size_t k = 0; k < s.martensite.size(); ++k) {
      ASSERT_GE(s.martensite[k], 0);
      ASSERT_GE(s.r_phase[k], 0);
      ASSERT_LE(s.martensite[k] + s.r_phase[k], 1 + 1e-12);
    }
  }
}

TEST(FreeEnergy, IsWhollyTransformedFarFromItsThresholds) {
  const K::Params p = K::params(spread);
  for (const double stress_Pa : {0.0, 1e8, 3e8}) {
    K::State s = K::rest(p, {240, stress_Pa});
    EXPECT_GT(K::phases(s).martensite, 0.999);
    K::advance(p, s, {460, stress_Pa});
    EXPECT_GT(K::phases(s).austenite(), 0.999);
  }
}

/// Without spread, half has jumped where the integral of p over time is ln 2.
TEST(FreeEnergy, TransformsLaterWhenItIsHeatedFaster) {
  double before_K = 0;
  for (const double K_s : {0.1, 1.0, 10.0, 100.0, 1000.0}) {
    const FreeEnergySpread of = one_part();
    const double gone_K =
        of.m2a.median_K + of.width_K * std::sqrt(2 * std::log(0.1 / of.attempt_s));
    double jumped = 0;
    double T = 270;
    for (; jumped < std::log(2.0); T += 1e-3) {
      const double z = std::max(gone_K - T, 0.0) / of.width_K;
      jumped += std::exp(-0.5 * z * z) / of.attempt_s * 1e-3 / K_s;
    }
    const double reached_K = half_K(of, K_s);
    EXPECT_NEAR(reached_K, T, 0.03) << K_s << " K/s";
    EXPECT_GT(reached_K, before_K + 0.5);
    before_K = reached_K;
  }
}

TEST(FreeEnergy, GoesOnWhileTheDriveRests) {
  const K::Params p = K::params(spread);
  K::State s = K::rest(p, {270, 1e8});
  K::advance(p, s, {355, 1e8}, 1e-3);
  double before = K::phases(s).martensite;
  double first = 0;
  double last = 0;
  for (int second = 0; second < 20; ++second) {
    for (int i = 0; i < 1000; ++i) {
      K::advance(p, s, {355, 1e8}, 1e-3);
    }
    last = before - K::phases(s).martensite;
    EXPECT_GT(last, 0) << "austenite grows";
    first = second == 0 ? last : first;
    before = K::phases(s).martensite;
  }
  EXPECT_GT(first, 10 * last) << "ever more slowly";
  EXPECT_GT(before, 0.05) << "and not to its end";
}

TEST(FreeEnergy, OneStepAtRestIsAsManySmallOnes) {
  const K::Params p = K::params(one_part());
  K::State once = K::rest(p, {270, 0});
  K::State often = once;
  K::advance(p, once, {346, 0}, 0.1);
  for (int i = 0; i < 1000; ++i) {
    K::advance(p, often, {346, 0}, 1e-4);
  }
  EXPECT_NEAR(K::phases(once).martensite, K::phases(often).martensite, 1e-10);
  EXPECT_GT(K::phases(once).martensite, 0.1);
  EXPECT_LT(K::phases(once).martensite, 0.9);
}

/// Where stress shifts all processes alike it shifts the whole wire.
TEST(FreeEnergy, StressShiftsItByClausiusAndClapeyron) {
  FreeEnergySpread of = spread;
  for (ThresholdSpread* process : {&of.m2a, &of.a2m, &of.r2a, &of.a2r}) {
    process->per_Pa = 0.14e-6;
    process->per_Pa2 = 0;
  }
  const K::Params p = K::params(of);
  K::State free = K::rest(p, {270, 0});
  K::State loaded = K::rest(p, {270 + 28, 2e8});
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> uniform(270, 400);
  for (int i = 0; i < 2000; ++i) {
    const double T = uniform(random);
    K::advance(p, free, {T, 0}, 1e-3);
    K::advance(p, loaded, {T + 28, 2e8}, 1e-3);
    ASSERT_NEAR(K::phases(free).martensite, K::phases(loaded).martensite, 1e-6);
    ASSERT_NEAR(K::phases(free).r_phase, K::phases(loaded).r_phase, 1e-6);
  }
}

TEST(FreeEnergy, NeighboursMakeTheTransformationSteeper) {
  const auto width_K = [](double coupling_K) {
    FreeEnergySpread of = spread;
    of.coupling_K = coupling_K;
    const K::Params p = K::params(of);
    K::State s = K::rest(p, {270, 0});
    double low_K = 0;
    double high_K = 0;
    for (double T = 270; T < 400; T += 0.01) {
      K::advance(p, s, {T, 0}, 1e-3);
      low_K = 0.8 < K::phases(s).martensite ? T : low_K;
      high_K = 0.2 < K::phases(s).martensite ? T : high_K;
    }
    return high_K - low_K;
  };
  // 60 % of the martensite between them: 0.6 J.
  EXPECT_NEAR(width_K(0) - width_K(4), 2.4, 0.5);
}

TEST(FreeEnergy, RatesAreTheSlopeOfItsStep) {
  const K::Params p = K::params(spread);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(290, 370);
  const double dt_s = 1e-5;
  double greatest = 0;
  K::State s = K::rest(p, {300, 1e8});
  for (int i = 0; i < 500; ++i) {
    const double T = uniform(random);
    K::advance(p, s, {T, 1e8}, 1e-2);
    K::advance(p, s, {T, 1e8}, dt_s);
    const PhaseRates<double> rates = K::rates(p, s, Heading::heating);
    K::State warmer = s;
    K::State colder = s;
    const double h_K = 1e-3;
    K::advance(p, warmer, {T + h_K, 1e8}, dt_s);
    K::advance(p, colder, {T - h_K, 1e8}, dt_s);
    const double slope = (K::phases(warmer).martensite - K::phases(colder).martensite) / (2 * h_K);
    EXPECT_NEAR(rates.martensite_1_K, slope, 0.02 * std::abs(slope) + 1e-7);
    EXPECT_LE(rates.martensite_1_K, 0);
    greatest = std::max(greatest, std::abs(slope));
  }
  EXPECT_GT(greatest, 1e-5);
}

}  // namespace
}  // namespace smaservo::test::free_energy_test
