// The plant with smooth hardening: the suite of all kinetics, and physics against other sources
// than its formulas: quadrature, a free energy, a fin.

#include "model/plants/smooth_hardening.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "model/wire/distributed.hpp"
#include "tests/model/kinetics_suite.hpp"
#include "tests/model/wire/test_wires.hpp"

namespace smaservo::test::smooth_hardening_test {
namespace {

/// About what the 76 um wire's surfaces give.
constexpr SmoothHardeningNumbers numbers{{337.4, 359.6, 0.9, 0.7, 1.24e-7, 2.95e-17},
                                         {326.8, 297.1, 0.7, 0.6, 1.31e-7, 3.12e-17},
                                         {319.55, 342.0, 0.3, 0.9, 2.58e-8, 3.41e-17},
                                         {338.0, 315.55, 0.9, 0.3, 2.58e-8, 3.41e-17},
                                         0.15,
                                         70e6};

struct SmoothDouble {
  using Model = SmoothHardening<double>;
  static Model::Params params() { return Model::params(numbers); }
  /// A fraction rests wherever it was left, between two temperatures far apart.
  static constexpr InnerLoops loops = InnerLoops::dead_band;
  static constexpr double rounding = 1e-12;
};

struct SmoothFloat : SmoothDouble {
  using Model = SmoothHardening<float>;
  static Model::Params params() { return Model::params(numbers); }
  static constexpr double rounding = 1e-5;
};

using Both = ::testing::Types<SmoothDouble, SmoothFloat>;
using InDouble = ::testing::Types<SmoothDouble>;
INSTANTIATE_TYPED_TEST_SUITE_P(SmoothHardening, KineticsSuite, Both);
INSTANTIATE_TYPED_TEST_SUITE_P(SmoothHardening, ExactSteps, Both);
INSTANTIATE_TYPED_TEST_SUITE_P(SmoothHardening, BranchRates, InDouble);
// What has transformed last goes back first, so loops close without being remembered.
INSTANTIATE_TYPED_TEST_SUITE_P(SmoothHardening, ReturnPoints, InDouble);

using K = SmoothHardening<double>;
class SmoothHardeningTest : public KineticsSuite<SmoothDouble> {
 protected:
  /// The temperature at which this much is martensite on cooling or on heating.
  double martensite_at_K(double share, double stress_MPa, bool heating) {
    const State s = K::rest(params, at(heating ? 240 : 500, stress_MPa));
    double low_K = 240;
    double high_K = 500;
    while (1e-9 < high_K - low_K) {
      const double T = 0.5 * (low_K + high_K);
      State trial = s;
      move(trial, at(T, stress_MPa));
      (share < K::phases(trial).martensite ? low_K : high_K) = T;
    }
    return low_K;
  }
};

/// The alloy that the energies of this test are those of, as the 76 um wire's file has it.
constexpr double density_kg_m3 = 6450;
constexpr double latent_m2a_J_kg = 20e3;
constexpr double latent_r2a_J_kg = 6e3;

/// What a stress does on the strain of martensite or R-phase while it forms, per volume, by
/// Simpson's rule from the plant's own strain.
double work_J_m3(bool martensite, double stress_Pa) {
  using Plant = DistributedPlant<K, 2>;
  Plant::Params p{};
  p.material = paper_wire().material;
  p.geometry = paper_wire().geometry;
  p.length_m.fill(0.5 * p.geometry.length_m);
  p.strain_deficit = numbers.strain_deficit;
  p.strain_saturation_Pa = numbers.saturation_Pa;
  const auto longer_by = [&](double at_Pa) {
    Plant::State s{};
    s.profile.stress_Pa = at_Pa;
    const double austenite = Plant::strain(p, s);
    (martensite ? s.profile.martensite : s.profile.r_phase).fill(1);
    return Plant::strain(p, s) - austenite;
  };
  constexpr int parts = 200;
  double sum = 0;
  for (int i = 0; i <= parts; ++i) {
    const double weight = i == 0 || i == parts ? 1 : i % 2 == 1 ? 4 : 2;
    sum += weight * longer_by(stress_Pa * i / parts);
  }
  return sum * stress_Pa / parts / 3;
}

TEST(SmoothHardening, WithoutExponentsTheFractionIsAStraightLine) {
  SmoothHardeningNumbers straight = numbers;
  straight.a2m.first = straight.a2m.last = 1;
  const K::Params p = K::params(straight);
  K::State s = K::rest(p, {400, 0});
  for (const double share : {0.1, 0.25, 0.5, 0.8, 0.97}) {
    K::advance(p, s, {326.8 - share * (326.8 - 297.1), 0});
    EXPECT_NEAR(K::phases(s).martensite, share, 1e-12);
  }
}

/// With equal exponents both ends are alike; with smaller ones they are smoother, and the middle is
/// steeper.
TEST(SmoothHardening, BeginsAndEndsSmoothly) {
  double steepest_before = 0;
  for (const double n : {1.0, 0.8, 0.5, 0.3}) {
    SmoothHardeningNumbers of = numbers;
    of.a2m.first = of.a2m.last = n;
    const K::Params p = K::params(of);
    const auto slope = [&](double share_of_way) {
      K::State s = K::rest(p, {400, 0});
      K::advance(p, s, {326.8 - share_of_way * (326.8 - 297.1), 0});
      return -K::rates(p, s, Heading::cooling).martensite_1_K;
    };
    const double middle = slope(0.5);
    EXPECT_GT(middle, steepest_before) << n;
    steepest_before = middle;
    for (const double way : {1e-6, 0.1, 0.3}) {
      EXPECT_NEAR(slope(way), slope(1 - way), 1e-6 * middle) << n;
    }
    // h is about x^n/2 there: dx/dT goes with T^(1/n - 1).
    const double start = slope(1e-8);
    const double expected =
        n == 1.0 ? middle : std::pow(2e-8, 1 / n - 1) * 2 / (n * (326.8 - 297.1));
    EXPECT_NEAR(start, expected, 0.03 * expected) << n;
  }
}

TEST(SmoothHardening, IsWhollyTransformedBeyondItsLastTemperatures) {
  const K::Params p = K::params(numbers);
  K::State s = K::rest(p, {326.81, 0});
  EXPECT_EQ(K::phases(s).martensite, 0);
  K::advance(p, s, {326.7, 0});
  EXPECT_GT(K::phases(s).martensite, 0);
  K::advance(p, s, {297.2, 0});
  EXPECT_LT(K::phases(s).martensite, 1);
  K::advance(p, s, {297.1, 0});
  EXPECT_EQ(K::phases(s).martensite, 1);
  K::advance(p, s, {337.4, 0});
  EXPECT_EQ(K::phases(s).martensite, 1);
  K::advance(p, s, {359.6, 0});
  EXPECT_EQ(K::phases(s).austenite(), 1);
}

TEST_F(SmoothHardeningTest, StressShiftsMartensiteByItsWorkOnThePlantsStrain) {
  for (const bool heating : {false, true}) {
    for (const double share : {0.2, 0.5, 0.8}) {
      const double none_K = martensite_at_K(share, 0, heating);
      const double full_K = martensite_at_K(share, 400, heating) - none_K;
      for (const double stress_MPa : {20.0, 80.0, 200.0, 300.0}) {
        const double expected_K =
            full_K * work_J_m3(true, stress_MPa * 1e6) / work_J_m3(true, 400e6);
        // The compliances of the numbers above are rounded to three digits.
        EXPECT_NEAR(martensite_at_K(share, stress_MPa, heating) - none_K, expected_K, 0.05)
            << stress_MPa << " MPa";
      }
      EXPECT_GT(full_K / 400, 0.12);
      EXPECT_LT(full_K / 400, 0.16);
    }
  }
}

TEST_F(SmoothHardeningTest, StressShiftsRPhaseByClausiusAndClapeyron) {
  const auto r_phase_at_K = [&](double stress_MPa) {
    double T = 400;
    for (State s = K::rest(params, at(T, stress_MPa)); K::phases(s).r_phase < 0.1 && 250 < T;) {
      T -= 1e-3;
      move(s, at(T, stress_MPa));
    }
    return T;
  };
  const double none_K = r_phase_at_K(0);
  for (const double stress_MPa : {20.0, 50.0, 80.0}) {
    const double expected_K =
        332 * work_J_m3(false, stress_MPa * 1e6) / (density_kg_m3 * latent_r2a_J_kg);
    EXPECT_NEAR(r_phase_at_K(stress_MPa) - none_K, expected_K, 0.03 * expected_K + 2e-3);
  }
}

/// About 70 % at 10 MPa, felt up to almost 250 MPa (paper 000).
TEST_F(SmoothHardeningTest, RPhaseHasTheShareThatIsMeasured) {
  const auto peak = [&](double stress_MPa) {
    double most = 0;
    State s = K::rest(params, at(450, stress_MPa));
    for (double T = 450; T > 280; T -= 0.1) {
      move(s, at(T, stress_MPa));
      most = std::max(most, K::phases(s).r_phase);
    }
    std::printf("%3.0f MPa: at most %.3f of R-phase\n", stress_MPa, most);
    return most;
  };
  EXPECT_NEAR(peak(10), 0.7, 0.1);
  EXPECT_NEAR(peak(100), 0.55, 0.1);
  EXPECT_NEAR(peak(250), 0.1, 0.05);
}

/// No path leads from martensite to R-phase but for what the parent phase of its first percents
/// has.
TEST_F(SmoothHardeningTest, HeatedMartensiteBecomesAustenite) {
  for (const double stress_MPa : {0.0, 50.0, 150.0, 300.0}) {
    State s = K::rest(params, at(250, stress_MPa));
    double most = 0;
    for (double T = 250; T < 450; T += 0.1) {
      move(s, at(T, stress_MPa));
      most = std::max(most, K::phases(s).r_phase);
    }
    EXPECT_LT(most, 0.02) << stress_MPa;
    EXPECT_EQ(K::phases(s).austenite(), 1);
  }
}

TEST_F(SmoothHardeningTest, AnInterruptedTransformationRestsAndGoesOn) {
  State s = K::rest(params, at(450, 150));
  const double turn_K = martensite_at_K(0.5, 150, false);
  const double back_K = martensite_at_K(0.5, 150, true);
  EXPECT_GT(back_K, turn_K + 25);
  move(s, at(turn_K, 150));
  const double left = K::phases(s).martensite;
  EXPECT_NEAR(left, 0.5, 1e-9);
  move(s, at(back_K - 1e-6, 150));
  EXPECT_EQ(K::phases(s).martensite, left);
  move(s, at(back_K + 1, 150));
  EXPECT_LT(K::phases(s).martensite, left - 0.02);
  State straight = K::rest(params, at(250, 150));
  move(straight, at(back_K + 1, 150));
  EXPECT_NEAR(K::phases(s).martensite, K::phases(straight).martensite, 1e-12);
}

/// Temperature and stress round a rectangle: martensite by cold and load, austenite by heat and
/// release.
TEST_F(SmoothHardeningTest, ALoopOfTemperatureAndStressReturnsToItsStart) {
  State s = K::rest(params, at(300, 20));
  const auto round = [&] {
    std::vector<State> corners;
    for (const auto& corner : {at(352, 20), at(352, 350), at(300, 350), at(300, 20)}) {
      ramp(s, corner, 15);
      corners.push_back(s);
    }
    return corners;
  };
  const std::vector<State> once = round();
  const std::vector<State> again = round();
  EXPECT_GT(difference(once[0], once[1]), 0.2);
  EXPECT_GT(difference(once[0], once[3]), 0.3);
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_LT(difference(once[i], again[i]), 1e-14) << i;
  }
  State whole = K::rest(params, at(250, 0));
  const State start = whole;
  for (const auto& corner : {at(450, 0), at(450, 300), at(250, 300), at(250, 0)}) {
    ramp(whole, corner, 15);
  }
  EXPECT_EQ(difference(whole, start), 0);
}

/// The free energy of parent phase and martensite per volume, with the latent heats and the work of
/// the stress, and energy stored half way between heating and cooling:
///
///   G = m g_M + Φ_M(m) + (1 - m) (q g_R + Φ_R(q)),   g = Δs T - W(σ),   dΦ/dx = -Δs T_middle(x)
class FreeEnergyOfPhases {
 public:
  FreeEnergyOfPhases() {
    for (int i = 0; i <= 41; ++i) {
      m_work_.push_back(work_J_m3(true, i * 10e6));
      r_work_.push_back(work_J_m3(false, i * 10e6));
    }
  }

  /// What a step loses by the change of m, and by that of q: -∂G/∂m dm and -∂G/∂q dq.
  std::array<double, 2> lost_J_m3(const K::State& before, const K::State& after) const {
    const auto [T, stress_Pa] = K::drive(after);
    const double m_before = K::phases(before).martensite;
    const double m = K::phases(after).martensite;
    const double q = r_share(after);
    double stored_J_m3 = 0;
    for (int i = 0; i < 20; ++i) {
      stored_J_m3 -= r_J_m3K * middle_K(numbers.a2r, numbers.r2a, q * (i + 0.5) / 20) * q / 20;
    }
    const double parent_J_m3 = q * (r_J_m3K * T - at_stress(r_work_, stress_Pa)) + stored_J_m3;
    const double m_force_J_m3 = m_J_m3K * (middle_K(numbers.a2m, numbers.m2a, m) - T) +
                                at_stress(m_work_, stress_Pa) + parent_J_m3;
    const double q_force_J_m3 = (1 - m) * (r_J_m3K * (middle_K(numbers.a2r, numbers.r2a, q) - T) +
                                           at_stress(r_work_, stress_Pa));
    // Where all is martensite, q is not seen.
    const double dq = m_before < 1 && m < 1 ? q - r_share(before) : 0;
    return {m_force_J_m3 * (m - m_before), q_force_J_m3 * dq};
  }

 private:
  static constexpr double m_J_m3K = density_kg_m3 * latent_m2a_J_kg / 330;
  static constexpr double r_J_m3K = density_kg_m3 * latent_r2a_J_kg / 332;

  static double r_share(const K::State& s) {
    const Phases<double> z = K::phases(s);
    return z.martensite < 1 ? z.r_phase / (1 - z.martensite) : 0;
  }
  static double curve_K(const SmoothTransformation<double>& t, double x) {
    return t.from_K +
           (t.to_K - t.from_K) * 0.5 * (1 + std::pow(x, t.first) - std::pow(1 - x, t.last));
  }
  /// Half way between the two curves.
  static double middle_K(const SmoothTransformation<double>& cooling,
                         const SmoothTransformation<double>& heating, double x) {
    return 0.5 * (curve_K(cooling, x) + curve_K(heating, 1 - x));
  }
  static double at_stress(const std::vector<double>& work_J_m3, double stress_Pa) {
    const auto i = static_cast<std::size_t>(stress_Pa / 10e6);
    const double share = stress_Pa / 10e6 - static_cast<double>(i);
    return work_J_m3[i] + share * (work_J_m3[i + 1] - work_J_m3[i]);
  }

  std::vector<double> m_work_, r_work_;  // each 10 MPa
};

/// The second law: the driving force of a transformation times its rate is never negative.
TEST_F(SmoothHardeningTest, NoPathGainsFreeEnergy) {
  const FreeEnergyOfPhases energy;
  double least_J_m3 = 0;
  double sum_J_m3 = 0;
  int moved = 0;
  for (int walk = 0; walk < 60; ++walk) {
    State s = wandered(0);
    for (int leg = 0; leg < 20; ++leg) {
      const Drive<double> from = K::drive(s);
      const Drive<double> to = at(uniform(270, 440), uniform(0, 400));
      for (int step = 1; step <= 400; ++step) {
        const State before = s;
        const double share = step / 400.0;
        move(s, {from.temperature_K + share * (to.temperature_K - from.temperature_K),
                 from.stress_Pa + share * (to.stress_Pa - from.stress_Pa)});
        const auto [m_J_m3, q_J_m3] = energy.lost_J_m3(before, s);
        least_J_m3 = std::min({least_J_m3, m_J_m3, q_J_m3});
        sum_J_m3 += m_J_m3 + q_J_m3;
        moved += difference(before, s) > 0 ? 1 : 0;
      }
    }
  }
  std::printf("%.3g MJ/m3 in %d steps that transformed, least %.2g J/m3\n", sum_J_m3 / 1e6, moved,
              least_J_m3);
  EXPECT_GT(moved, 10000);
  EXPECT_GT(least_J_m3, -1e-3);
}

constexpr std::size_t segments = 24;
using Plant = DistributedPlant<K, segments>;

/// The 76 um wire with short segments at its ends.
Plant::Params plant() {
  Plant::Params p{};
  p.kinetics.fill(K::params(numbers));
  p.material = paper_wire().material;
  p.heat = paper_wire().heat;
  p.geometry = paper_wire().geometry;
  double sum = 0;
  for (std::size_t i = 0; i < segments; ++i) {
    const std::size_t from_clamp = std::min(i, segments - 1 - i);
    p.length_m[i] = std::exp2(from_clamp < 5 ? 0.0 : static_cast<double>(from_clamp - 5));
    sum += p.length_m[i];
  }
  for (double& length_m : p.length_m) {
    length_m *= p.geometry.length_m / sum;
  }
  p.strain_deficit = numbers.strain_deficit;
  p.strain_saturation_Pa = numbers.saturation_Pa;
  return p;
}

/// Heat in less heat out, through air and clamps, over a cycle of heating and cooling that ends
/// where it began: nothing is left, though the latent heat went in and out.
TEST(SmoothHardening, AClosedCycleTakesNoHeat) {
  Plant::Params p = plant();
  p.clamp_resistance_m = 0.4e-3;
  const double stress_Pa = 150e6;
  const double dt_s = 1e-3;
  Plant::State s = Plant::rest(p, {room_K, stress_Pa});
  const double strain = Plant::strain(p, s);
  double in_J = 0;
  double left_J = 0;
  double most_left_J = 0;
  for (int step = 0; step < 20000; ++step) {
    const double current = step < 4000 ? 0.14 : 0;
    const double joule_J = current * current * Plant::resistance_ohm(p, s) * dt_s;
    std::array<double, segments> loss_J_K{};
    for (std::size_t i = 0; i < segments; ++i) {
      loss_J_K[i] = dt_s * p.geometry.surface_m2() * p.length_m[i] / p.geometry.length_m *
                    p.convection.h_W_m2K(p.geometry.diameter_m, Plant::temperature_K(s, i), room_K);
    }
    Plant::advance(p, s, current, {stress_Pa, room_K}, 1.0, dt_s);
    in_J += joule_J;
    left_J += joule_J;
    for (std::size_t i = 0; i < segments; ++i) {
      const bool end = i == 0 || i + 1 == segments;
      const double clamp_J_K = dt_s * p.heat.clamp_conductivity_W_mK * p.geometry.area_m2() /
                               (0.5 * p.length_m[i] + p.clamp_resistance_m);
      left_J -= (loss_J_K[i] + (end ? clamp_J_K : 0)) * (Plant::temperature_K(s, i) - room_K);
    }
    most_left_J = std::max(most_left_J, left_J);
  }
  const double mass_kg = density_kg_m3 * p.geometry.area_m2() * p.geometry.length_m;
  EXPECT_GT(most_left_J, 0.9 * latent_m2a_J_kg * mass_kg) << "it was transformed";
  EXPECT_NEAR(left_J, 0, 1e-6 * in_J);
  EXPECT_NEAR(Plant::strain(p, s), strain, 1e-9);
}

/// The temperatures of a fin of half the wire's length, each 10 um from its clamp, by relaxation:
///
///   k A T'' = h(T) π d (T - T_a) - heat,   at the clamp k A T' = k A (T - T_a)/resistance
std::vector<double> fin_K(const Plant::Params& p, double heat_W_m) {
  const double dx_m = 1e-5;
  const auto count = static_cast<std::size_t>(0.5 * p.geometry.length_m / dx_m);
  const double kA_W_m = p.heat.clamp_conductivity_W_mK * p.geometry.area_m2();
  const double perimeter_m = p.geometry.surface_m2() / p.geometry.length_m;
  std::vector<double> T(count, 380);
  for (int turn = 0; turn < 30; ++turn) {
    // (a_i + b_i) T_i - a_i T_(i-1) - b_i T_(i+1) + loss (T_i - T_a) = heat, by elimination
    std::vector<double> factor(count), right(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double loss_W_K =
          natural_convection_W_m2K(p.geometry.diameter_m, T[i], room_K) * perimeter_m * dx_m;
      const double a = kA_W_m / (i == 0 ? 0.5 * dx_m + p.clamp_resistance_m : dx_m);
      const double b = i + 1 == count ? 0 : kA_W_m / dx_m;
      const double known_W =
          heat_W_m * dx_m + loss_W_K * room_K + a * (i == 0 ? room_K : right[i - 1]);
      const double diagonal = a + b + loss_W_K - (i == 0 ? 0 : a * factor[i - 1]);
      factor[i] = b / diagonal;
      right[i] = known_W / diagonal;
    }
    for (std::size_t i = count - 1; i-- > 0;) {
      right[i] += factor[i] * right[i + 1];
    }
    T = right;
  }
  return T;
}

/// A hot wire's ends stay martensite as far as a fin between its clamps is colder than M2A.
TEST(SmoothHardening, EndsThatStayMartensiteKeepAHotWireLong) {
  for (const double clamp_resistance_m : {0.0, 0.4e-3}) {
    Plant::Params p = plant();
    p.clamp_resistance_m = clamp_resistance_m;
    const double current_A = 0.15;
    const double stress_Pa = 150e6;
    const double hot = stress_Pa / 70e9;
    const double longer =
        0.04 * (1 - 0.15 * std::exp(-stress_Pa / 70e6)) + stress_Pa / 30e9 - stress_Pa / 70e9;
    // Martensite of as much resistance as austenite: the same heat everywhere.
    const double rho_ohm_m = p.material.austenite.resistivity_ohm_m;
    p.material.martensite.resistivity_ohm_m = rho_ohm_m * (1 + 2 * hot) / (1 + 2 * (hot + longer));
    for (Phase<double>* phase : {&p.material.martensite, &p.material.austenite}) {
      phase->resistivity_ohm_m_K = phase->resistivity_ohm_m_Pa = 0;
    }
    Plant::State s = Plant::rest(p, {room_K, stress_Pa});
    for (int step = 0; step < 20000; ++step) {
      Plant::advance(p, s, current_A, {stress_Pa, room_K}, 1.0, 1e-3);
    }
    const std::vector<double> fin =
        fin_K(p, current_A * current_A * rho_ohm_m * (1 + 2 * hot) / p.geometry.area_m2());
    double expected_m = 0;
    for (const double T : fin) {
      K::State heated = K::rest(p.kinetics[0], {room_K, stress_Pa});
      K::advance(p.kinetics[0], heated, {T, stress_Pa});
      expected_m += 1e-5 * K::phases(heated).martensite;
    }
    const double missing = Plant::strain(p, s) - hot;
    const double cold_m = missing / longer * p.geometry.length_m / 2;
    std::printf("%.1f K, fin %.1f K: %.3f mm of each end are martensite, of the fin's %.3f mm\n",
                Plant::temperature_K(s, segments / 2), fin.back(), 1e3 * cold_m, 1e3 * expected_m);
    EXPECT_NEAR(Plant::temperature_K(s, segments / 2), fin.back(), 0.5);
    EXPECT_NEAR(cold_m, expected_m, 0.03 * expected_m);
    EXPECT_GT(cold_m, 0.9e-3);
    EXPECT_EQ(s.profile.martensite[0], 1);
    EXPECT_EQ(s.profile.martensite[segments / 2], 0);
  }
}

}  // namespace
}  // namespace smaservo::test::smooth_hardening_test
