#include "model/papers/duhem.hpp"

#include <algorithm>
#include <ceres/jet.h>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "model/units.hpp"

namespace smaservo::duhem_test {
namespace {

using Model = papers::Duhem<double>;

/// Table I of 001.
constexpr Model::Params table_1{{zero_degC_K + 78.9, 11.2, 0}, {zero_degC_K + 34, 5.8, 0}};
/// A loop so narrow and wide in its slopes that both processes act nearly everywhere.
constexpr Model::Params overlapping{{zero_degC_K + 60, 7, 0}, {zero_degC_K + 48, 6, 0}};

Drive<double> at(double celsius) {
  return {celsius + zero_degC_K, 0};
}

/// 001 eq. 6, by the error function itself.
double h(const Model::Process& process, double celsius) {
  const double z = (celsius + zero_degC_K - process.centre_K) / process.deviation_K;
  return 0.5 * (1 + std::erf(z / std::numbers::sqrt2));
}

double g(const Model::Process& process, double celsius) {
  const double z = (celsius + zero_degC_K - process.centre_K) / process.deviation_K;
  return std::exp(-z * z / 2) / (process.deviation_K * std::sqrt(2 * std::numbers::pi));
}

/// 001 eq. 12 as it is printed.
double printed_slope(const Model::Params& p, double celsius, double R_m, bool heating) {
  const double rising = h(p.m2a, celsius);
  const double falling = h(p.a2m, celsius);
  return heating ? (falling + R_m - 1) / (rising - falling) * g(p.m2a, celsius)
                 : (rising + R_m - 1) / (falling - rising) * g(p.a2m, celsius);
}

/// 001 eq. 12 integrated by Runge and Kutta's fourth order in steps of 0.01 K: the oracle.
double integrated(const Model::Params& p, double R_m, double from, double to) {
  const int steps = static_cast<int>(std::ceil(std::abs(to - from) / 0.01));
  const double step = (to - from) / steps;
  const bool heating = to > from;
  for (int i = 0; i < steps; ++i) {
    const double T = from + i * step;
    const double k1 = printed_slope(p, T, R_m, heating);
    const double k2 = printed_slope(p, T + step / 2, R_m + step / 2 * k1, heating);
    const double k3 = printed_slope(p, T + step / 2, R_m + step / 2 * k2, heating);
    const double k4 = printed_slope(p, T + step, R_m + step * k3, heating);
    R_m += step / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return R_m;
}

TEST(Duhem, StepsSolveTheDifferentialEquation) {
  for (const Model::Params& p : {table_1, overlapping}) {
    std::mt19937_64 random{1};
    std::uniform_real_distribution<double> anywhere(25, 105);
    double worst = 0;
    double T = 105;
    Model::State s = Model::rest(p, at(T));
    double R_m = s.martensite;
    for (int turn = 0; turn < 200; ++turn) {
      const double next = anywhere(random);
      Model::advance(p, s, at(next));
      R_m = integrated(p, R_m, T, next);
      worst = std::max(worst, std::abs(s.martensite - R_m));
      T = next;
    }
    std::printf("worst difference to the integrated equation: %.2g\n", worst);
    EXPECT_LT(worst, 1e-10);
  }
}

TEST(Duhem, MajorLoopIsTheErrorFunction) {
  for (const Model::Params& p : {table_1, overlapping}) {
    Model::State s = Model::rest(p, at(-200));
    EXPECT_EQ(s.martensite, 1);
    for (double T = -50; T <= 200; T += 3.7) {
      Model::advance(p, s, at(T));
      EXPECT_NEAR(s.martensite, 1 - h(p.m2a, T), 1e-13) << T;
    }
    Model::advance(p, s, at(300));
    for (double T = 200; T >= -10; T -= 3.7) {
      Model::advance(p, s, at(T));
      EXPECT_NEAR(s.martensite, 1 - h(p.a2m, T), 1e-13) << T;
      EXPECT_NEAR(Model::rest(p, at(T)).martensite, s.martensite, 1e-13) << T;
    }
  }
}

TEST(Duhem, MinorLoopsStayInsideTheMajorOne) {
  for (const Model::Params& p : {table_1, overlapping}) {
    std::mt19937_64 random{2};
    std::uniform_real_distribution<double> anywhere(-10, 130);
    Model::State s = Model::rest(p, at(150));
    for (int turn = 0; turn < 5000; ++turn) {
      const double T = anywhere(random);
      Model::advance(p, s, at(T));
      ASSERT_GE(s.martensite, 1 - h(p.a2m, T) - 1e-13) << T;
      ASSERT_LE(s.martensite, 1 - h(p.m2a, T) + 1e-13) << T;
    }
  }
}

TEST(Duhem, NothingTransformsInTheDeadZone) {
  // 001 section VII: between M_s and A_s, which Table I puts at 48 and 58 °C where it lets
  // convection and capacity change (m_1, m_2). A Gaussian is never quite over: the zone is dead
  // only to h_+(58 °C) = 3.1 % and 1 - h_-(48 °C) = 0.8 % of what there is to convert.
  for (const double inside : {0.2, 0.5, 0.8}) {
    Model::State s = Model::rest(table_1, at(150));
    Model::advance(table_1, s, at(table_1.a2m.centre_K - zero_degC_K));
    Model::advance(table_1, s, at(table_1.m2a.centre_K - zero_degC_K - 6 + 12 * inside));
    Model::advance(table_1, s, at(58));
    const double begin = s.martensite;
    Model::advance(table_1, s, at(48));
    EXPECT_LT(std::abs(s.martensite - begin), 0.008);
    const double cold = s.martensite;
    Model::advance(table_1, s, at(58));
    EXPECT_LT(std::abs(s.martensite - cold), 0.031);
  }
}

TEST(Duhem, EqualStressSlopesOnlyShiftTheLoop) {
  Model::Params stressed = overlapping;
  stressed.m2a.stress_K_Pa = stressed.a2m.stress_K_Pa = 0.13e-6;
  std::mt19937_64 random{3};
  std::uniform_real_distribution<double> anywhere(20, 90);
  std::uniform_real_distribution<double> stress(0, 400e6);
  Model::State plain = Model::rest(overlapping, at(90));
  Model::State shifted = Model::rest(stressed, at(90));
  for (int turn = 0; turn < 1000; ++turn) {
    const double T = anywhere(random);
    const double stress_Pa = stress(random);
    Model::advance(overlapping, plain, at(T));
    Model::advance(stressed, shifted, {T + zero_degC_K + 0.13e-6 * stress_Pa, stress_Pa});
    ASSERT_NEAR(plain.martensite, shifted.martensite, 1e-11);
  }
}

TEST(Duhem, WithoutALoopThereIsOneCurveReachedWithoutAJump) {
  // The curves cross at 2.5 deviations below the centres, at 25 °C; below there is no loop.
  const Model::Params crossing{{zero_degC_K + 50, 10, 0}, {zero_degC_K + 35, 4, 0}};
  EXPECT_TRUE(Model::ordered(crossing, at(25.01)));
  EXPECT_FALSE(Model::ordered(crossing, at(24.99)));
  std::mt19937_64 random{4};
  std::normal_distribution<double> ripple(0, 0.5);
  double T = 40;
  Model::State s = Model::rest(crossing, at(T));
  int closed = 0;
  for (int i = 0; i < 20000; ++i) {
    const double before = s.martensite;
    const double step = std::clamp(T + ripple(random), 15.0, 45.0) - T;
    T += step;
    Model::advance(crossing, s, at(T));
    // No slope is steeper than those of both curves.
    ASSERT_LE(std::abs(s.martensite - before), 0.11 * std::abs(step) + 1e-13) << T;
    if (!Model::ordered(crossing, at(T))) {
      ++closed;
      ASSERT_DOUBLE_EQ(s.martensite, Model::rest(crossing, at(T)).martensite);
      ASSERT_EQ(Model::rates(crossing, s, Heading::heating).martensite_1_K,
                Model::rates(crossing, s, Heading::cooling).martensite_1_K);
    }
  }
  EXPECT_GT(closed, 1000);
}

TEST(Duhem, SmallFractionsKeepTheirDigits) {
  // On the heating curve far above its centre: 001 eq. 6, by the complementary error function.
  Model::State s = Model::rest(table_1, at(0));
  for (int i = 1; i <= 100; ++i) {
    Model::advance(table_1, s, at(1.5 * i));
  }
  const double z = (150 - 78.9) / 11.2;
  const double exact = 0.5 * std::erfc(z / std::numbers::sqrt2);
  EXPECT_LT(exact, 1e-9);
  EXPECT_NEAR(s.martensite / exact, 1, 1e-6);
}

TEST(Duhem, DifferentiatesAutomatically) {
  using Jet = ceres::Jet<double, 1>;
  const auto martensite = [](auto centre_K) {
    using S = decltype(centre_K);
    using K = papers::Duhem<S>;
    const typename K::Params p{{centre_K, S(7), S(0)}, {S(zero_degC_K + 48), S(6), S(0)}};
    typename K::State s = K::rest(p, {S(zero_degC_K + 80), S(0)});
    for (const double T : {45.0, 58.0, 52.0, 61.0}) {
      K::advance(p, s, {S(zero_degC_K + T), S(0)});
    }
    return s.martensite;
  };
  const double centre_K = zero_degC_K + 60;
  const double by_difference = (martensite(centre_K + 1e-4) - martensite(centre_K - 1e-4)) / 2e-4;
  EXPECT_GT(by_difference, 0.01);
  EXPECT_NEAR(martensite(Jet(centre_K, 0)).v[0], by_difference, 1e-8);
}

}  // namespace
}  // namespace smaservo::duhem_test
