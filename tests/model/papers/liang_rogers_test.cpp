#include "model/papers/liang_rogers.hpp"

#include <algorithm>
#include <ceres/jet.h>
#include <cmath>
#include <cstddef>
#include <gtest/gtest.h>
#include <numbers>
#include <type_traits>
#include <vector>

#include "tests/model/wire/test_wires.hpp"

namespace smaservo::test::liang_rogers_test {
namespace {

using K = papers::LiangRogers<double>;
constexpr double pi = std::numbers::pi;

K::Params wire() {
  return flexinol_liang_rogers<double>();
}

/// The same wire without R-phase: its range is where no wire ever is.
K::Params without_r_phase() {
  K::Params p = wire();
  p.a2r = {2e-3, 1e-3, 1e12};
  return p;
}

Phases<double> moved(K::State& s, double temperature_K, double stress_Pa) {
  K::advance(wire(), s, {temperature_K, stress_Pa});
  return K::phases(s);
}

TEST(LiangRogers, FollowsThePapersEquationsOnHeating) {
  const K::Params p = wire();
  for (const double stress_Pa : {0.0, 60e6, 170e6}) {
    K::State s = K::rest(p, {300, stress_Pa});
    for (double T = 301; T < 400; T += 0.37) {
      const double low_K = p.m2a.start_K + stress_Pa / p.m2a.stress_Pa_K;
      const double high_K = p.m2a.finish_K + stress_Pa / p.m2a.stress_Pa_K;
      // 002 eq. 31 and 32
      const double expected = T <= low_K ? 1
                              : T >= high_K
                                  ? 0
                                  : 0.5 * (std::cos(pi / (high_K - low_K) * (T - low_K)) + 1);
      const Phases<double> z = moved(s, T, stress_Pa);
      EXPECT_NEAR(z.martensite, expected, 1e-12) << T;
      EXPECT_EQ(z.r_phase, 0);
    }
  }
}

TEST(LiangRogers, FollowsThePapersEquationsOnCooling) {
  const K::Params p = wire();
  for (const double stress_Pa : {0.0, 60e6, 120e6, 170e6}) {
    K::State s = K::rest(p, {420, stress_Pa});
    const double Mf = p.a2m.finish_K + stress_Pa / p.a2m.stress_Pa_K;
    const double Ms = p.a2m.start_K + stress_Pa / p.a2m.stress_Pa_K;
    const double Rf = p.a2r.finish_K + stress_Pa / p.a2r.stress_Pa_K;
    const double Rs = p.a2r.start_K + stress_Pa / p.a2r.stress_Pa_K;
    for (double T = 419; T > 300; T -= 0.37) {
      // 002 eq. 33, 34 with ξ_M0 = 0, and eq. 48
      const double M = T >= Ms ? 0 : T <= Mf ? 1 : 0.5 * (std::cos(pi / (Ms - Mf) * (T - Mf)) + 1);
      const double R = T >= Rs ? 0 : T <= Rf ? 1 : 0.5 * (std::cos(pi / (Rs - Rf) * (T - Rf)) + 1);
      const Phases<double> z = moved(s, T, stress_Pa);
      EXPECT_NEAR(z.martensite, M, 1e-12) << T;
      EXPECT_NEAR(z.r_phase, (1 - M) * R, 1e-12) << T;
    }
  }
}

// 002 eq. 33: what remains after an incomplete heating starts the next cooling.
TEST(LiangRogers, ScalesInnerLoopsAsInEquation33) {
  const K::Params p = wire();
  const double stress_Pa = 170e6;
  K::State s = K::rest(p, {300, stress_Pa});
  const double As = p.m2a.start_K + stress_Pa / p.m2a.stress_Pa_K;
  const double M0 = moved(s, As + 4, stress_Pa).martensite;
  EXPECT_TRUE(M0 > 0.3 && M0 < 0.8) << M0;
  const double Mf = p.a2m.finish_K + stress_Pa / p.a2m.stress_Pa_K;
  const double Ms = p.a2m.start_K + stress_Pa / p.a2m.stress_Pa_K;
  EXPECT_EQ(moved(s, Ms, stress_Pa).martensite, M0);
  const double T = Mf + 0.4 * (Ms - Mf);
  const double expected = (1 - M0) / 2 * (std::cos(pi / (Ms - Mf) * (T - Mf)) + 1) + M0;
  EXPECT_NEAR(moved(s, T, stress_Pa).martensite, expected, 1e-12);
}

TEST(LiangRogers, WithoutRPhaseIsTheTwoPhaseModel) {
  using Two = papers::Cosine<double>;
  const K::Params p = without_r_phase();
  const Two::Params q = flexinol_cosine<double>();
  K::State s = K::rest(p, {330, 50e6});
  Two::State t = Two::rest(q, {330, 50e6});
  for (int i = 0; i < 3000; ++i) {
    const Drive<double> u{335 + 25 * std::sin(0.07 * i) + 12 * std::sin(0.31 * i),
                          60e6 + 50e6 * std::sin(0.011 * i)};
    K::advance(p, s, u);
    Two::advance(q, t, u);
    ASSERT_NEAR(K::phases(s).martensite, Two::phases(t).martensite, 1e-12) << i;
    ASSERT_NEAR(K::phases(s).r_phase, 0, 1e-12) << i;
  }
}

// 002 figure 4: martensite comes before the R-phase where the stress is high.
TEST(LiangRogers, StressTakesTheRPhaseAway) {
  const auto max_r_phase = [](double stress_Pa) {
    K::State s = K::rest(wire(), {420, stress_Pa});
    double max = 0;
    for (double T = 420; T > 300; T -= 0.1) {
      max = std::max(max, moved(s, T, stress_Pa).r_phase);
    }
    return max;
  };
  EXPECT_GT(max_r_phase(10e6), 0.95);
  EXPECT_GT(max_r_phase(60e6), max_r_phase(130e6) + 0.1);
  EXPECT_LT(max_r_phase(300e6), 0.05);
}

TEST(LiangRogers, HeatingFromRPhaseMakesNoMartensite) {
  K::State s = K::rest(wire(), {420, 20e6});
  const Phases<double> cold = moved(s, 330, 20e6);
  ASSERT_GT(cold.r_phase, 0.9);
  for (double T = 330; T < 370; T += 0.1) {
    EXPECT_LE(moved(s, T, 20e6).martensite, cold.martensite + 1e-12);
  }
  EXPECT_NEAR(K::phases(s).austenite(), 1, 1e-12);
}

/// A path with inner loops, far from where branches begin or end.
template <class S>
Phases<S> after_a_walk(const typename papers::LiangRogers<S>::Params& p) {
  using Model = papers::LiangRogers<S>;
  typename Model::State s = Model::rest(p, {S(300), S(90e6)});
  for (const double T : {357.3, 342.1, 329.7, 361.2, 340.9}) {
    Model::advance(p, s, {S(T), S(90e6)});
  }
  return Model::phases(s);
}

// A fit differentiates through the model.
TEST(LiangRogers, DerivativesByItsParametersAreThoseOfDifferences) {
  using Jet = ceres::Jet<double, 9>;
  const K::Params p = wire();
  typename papers::LiangRogers<Jet>::Params q{};
  const auto members = [](auto& params) {
    using S = std::remove_reference_t<decltype(params.m2a.start_K)>;
    std::vector<S*> all;
    for (papers::CosineProcess<S>* process : {&params.m2a, &params.a2m, &params.a2r}) {
      all.insert(all.end(), {&process->start_K, &process->finish_K, &process->stress_Pa_K});
    }
    return all;
  };
  K::Params shifted = p;
  const std::vector<Jet*> jets = members(q);
  const std::vector<double*> numbers = members(shifted);
  for (int i = 0; i < 9; ++i) {
    const auto at = static_cast<std::size_t>(i);
    *jets[at] = Jet(*numbers[at], i);
  }
  const Phases<Jet> z = after_a_walk<Jet>(q);
  for (int i = 0; i < 9; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double step = 1e-6 * *numbers[at];
    const double middle = *numbers[at];
    *numbers[at] = middle + step;
    const Phases<double> above = after_a_walk<double>(shifted);
    *numbers[at] = middle - step;
    const Phases<double> below = after_a_walk<double>(shifted);
    *numbers[at] = middle;
    EXPECT_NEAR(z.martensite.v[i] * middle,
                (above.martensite - below.martensite) / (2 * step) * middle, 1e-4);
    EXPECT_NEAR(z.r_phase.v[i] * middle, (above.r_phase - below.r_phase) / (2 * step) * middle,
                1e-4);
    EXPECT_GT(std::abs(z.martensite.v[i]) + std::abs(z.r_phase.v[i]), 0) << i;
  }
}

// 002 eq. 30
TEST(MixedModulusStrain, IsThatOfTheMaterialInPurePhasesAndStifferBetween) {
  const Material<double>& m = paper_wire().material;
  for (const double stress_Pa : {0.0, 50e6, 200e6}) {
    for (const Phases<double> z : {Phases<double>{0, 0}, {1, 0}, {0, 1}}) {
      EXPECT_NEAR(papers::mixed_modulus_strain(m, z, stress_Pa), strain(m, z, stress_Pa), 1e-15);
    }
    const Phases<double> half{0.5, 0.2};
    const double E =
        0.5 * m.martensite.modulus_Pa + 0.2 * m.r_phase.modulus_Pa + 0.3 * m.austenite.modulus_Pa;
    EXPECT_NEAR(papers::mixed_modulus_strain(m, half, stress_Pa) -
                    papers::mixed_modulus_strain(m, half, 0.0),
                stress_Pa / E, 1e-15);
    EXPECT_LE(papers::mixed_modulus_strain(m, half, stress_Pa), strain(m, half, stress_Pa) + 1e-15);
  }
}

}  // namespace
}  // namespace smaservo::test::liang_rogers_test
