#include "model/wire/inverse.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "tests/bench/convert.hpp"
#include "tests/model/wire/test_wires.hpp"

namespace smaservo::test::inverse_test {
namespace {

using K = ThreePhase<double>;
using Model = Plant<K>;
using Inverted = Inverse<double>;

/// Every reversal counts, so that the forward model answers to the smallest goal.
Model::Params exact_wire() {
  Model::Params p = plant_params(paper_wire());
  p.kinetics.smallest_reversal_K = 0;
  return p;
}

/// The same with loops and ends that are not the paper's.
Model::Params ordered_wire() {
  Model::Params p = exact_wire();
  p.kinetics = ordered_kinetics();
  p.kinetics.smallest_reversal_K = 0;
  return p;
}

double strain_of(const Model::Params& p, const Phases<double>& middle, double stress_Pa) {
  return strain(p.material, p.ends.average(middle), stress_Pa);
}

/// The forward model is the oracle: this state at that temperature.
Phases<double> brought_to(const Model::Params& p, K::State s, double temperature_K,
                          double stress_Pa) {
  K::advance(p.kinetics, s, {temperature_K, stress_Pa});
  return K::phases(s);
}

/// Calls f(state, random) at every place of random walks of the temperature.
template <class F>
void along_histories(const Model::Params& p, double stress_Pa, int histories, F f) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (int h = 0; h < histories; ++h) {
    K::State s = K::rest(p.kinetics, {room_K, stress_Pa});
    double temperature_K = room_K;
    for (int i = 0; i < 30; ++i) {
      const double towards_K = i < 8 ? 6 : 0;
      temperature_K = std::clamp(temperature_K + 15 * normal(random) + towards_K, 290.0, 430.0);
      K::advance(p.kinetics, s, {temperature_K, stress_Pa});
      f(s, random);
    }
  }
}

double uniform(std::mt19937_64& random) {
  return std::uniform_real_distribution<double>()(random);
}

/// A strain between the present one and that at a temperature far away, or that at the end of the
/// transformation where the inverse ends before; small ones as well.
double random_goal(const Model::Params& p, const K::State& s, double stress_Pa, double far_K,
                   std::mt19937_64& random) {
  const double now = strain_of(p, K::phases(s), stress_Pa);
  const double far = strain_of(p, brought_to(p, s, far_K, stress_Pa), stress_Pa);
  const bool heats = far < now;
  const BranchPoint<double> last =
      heats ? Inverted::heating(p, s, stress_Pa, -1) : Inverted::cooling(p, s, stress_Pa, 1);
  const double there = strain_of(p, brought_to(p, s, last.temperature_K, stress_Pa), stress_Pa);
  const double end = heats ? std::max(far, there) : std::min(far, there);
  const double share = uniform(random);
  return now + share * share * (end - now);
}

class InverseAt : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(MPa, InverseAt, ::testing::Values(10, 25, 50, 100, 150, 250, 400),
                         [](const auto& MPa_) {
                           return std::to_string(static_cast<int>(MPa_.param));
                         });

class InverseOf : public ::testing::TestWithParam<std::tuple<double, bool>> {
 protected:
  static double stress_Pa() { return std::get<0>(GetParam()) * MPa; }
  static bool ordered() { return std::get<1>(GetParam()); }
  static Model::Params wire() { return ordered() ? ordered_wire() : exact_wire(); }
};
INSTANTIATE_TEST_SUITE_P(MPa, InverseOf,
                         ::testing::Combine(::testing::Values(10, 25, 50, 100, 150, 250, 400),
                                            ::testing::Bool()),
                         [](const auto& of) {
                           return std::to_string(static_cast<int>(std::get<0>(of.param))) +
                                  (std::get<1>(of.param) ? "Ordered" : "Paper");
                         });

TEST_P(InverseOf, HeatingIsTheForwardModelsInverse) {
  const Model::Params p = wire();
  const double stress_Pa = InverseOf::stress_Pa();
  double worst = 0, worst_phase = 0;
  along_histories(p, stress_Pa, 100, [&](const K::State& s, std::mt19937_64& random) {
    const double goal = random_goal(p, s, stress_Pa, 435, random);
    const BranchPoint<double> to = Inverted::heating(p, s, stress_Pa, goal);
    const Phases<double> z = brought_to(p, s, to.temperature_K, stress_Pa);
    worst = std::max(worst, std::abs(strain_of(p, z, stress_Pa) - goal));
    worst_phase = std::max({worst_phase, std::abs(z.martensite - to.phases.martensite),
                            std::abs(z.r_phase - to.phases.r_phase)});
  });
  // The ends of tapered curves are cut at 1e-5.
  EXPECT_LT(worst, ordered() ? 1e-6 : 1e-12);
  EXPECT_LT(worst_phase, ordered() ? 2e-5 : 1e-10);
}

/// Errors of the strain in % of the stroke: the worst one, and that of 95 % of the cases.
struct Errors {
  double worst, max;
};

using Way = BranchPoint<double> (*)(const Model::Params&, const K::State&, const double&,
                                    const double&);

Errors errors(const Model::Params& p, double stress_Pa, double far_K, Way inverse) {
  std::vector<double> errors;
  along_histories(p, stress_Pa, 100, [&](const K::State& s, std::mt19937_64& random) {
    const double goal = random_goal(p, s, stress_Pa, far_K, random);
    const double there_K = inverse(p, s, stress_Pa, goal).temperature_K;
    const Phases<double> z = brought_to(p, s, there_K, stress_Pa);
    errors.push_back(std::abs(strain_of(p, z, stress_Pa) - goal) * 100 /
                     paper_wire().nominal_stroke);
  });
  std::ranges::sort(errors);
  return {errors.back(), errors[errors.size() * 95 / 100]};
}
Errors cooling_errors(const Model::Params& p, double stress_Pa) {
  return errors(p, stress_Pa, 290, Inverted::cooling);
}
Errors heating_errors(const Model::Params& p, double stress_Pa) {
  return errors(p, stress_Pa, 435, Inverted::heating);
}

TEST_P(InverseOf, CoolingComesCloseToTheGoal) {
  const double stress_MPa = stress_Pa() / MPa;
  const Errors errors = cooling_errors(wire(), stress_Pa());
  std::printf("%3.0f MPa: worst %.4f, 95 %% %.4f %% of the stroke\n", stress_MPa, errors.worst,
              errors.max);
  if (ordered()) {
    EXPECT_LT(errors.worst, stress_MPa < 50 ? 27 : stress_MPa < 100 ? 2 : 0.3);
    EXPECT_LT(errors.max, 0.15);
    return;
  }
  EXPECT_LT(errors.worst, stress_MPa < 50 ? 4 : stress_MPa < 100 ? 1.2 : 0.04);
  EXPECT_LT(errors.max, stress_MPa < 100 ? 0.12 : 0.03);
}

TEST_P(InverseAt, FurtherGoalsLieFurtherAlong) {
  const Model::Params p = exact_wire();
  const double stress_Pa = GetParam() * MPa;
  along_histories(p, stress_Pa, 20, [&](const K::State& s, std::mt19937_64&) {
    const double now = strain_of(p, K::phases(s), stress_Pa);
    double hotter_K = 0;
    double colder_K = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= 50; ++i) {
      const double away = 0.06 * i / 50;
      const BranchPoint<double> hot = Inverted::heating(p, s, stress_Pa, now - away);
      const BranchPoint<double> cold = Inverted::cooling(p, s, stress_Pa, now + away);
      ASSERT_GE(hot.temperature_K, hotter_K);
      ASSERT_LE(cold.temperature_K, colder_K + (stress_Pa < 50e6 ? 0.1 : 1e-9)) << "by " << away;
      hotter_K = hot.temperature_K;
      colder_K = cold.temperature_K;
    }
  });
}

TEST_P(InverseAt, GoalsOutOfReachEndWhereTheTransformationDoes) {
  const Model::Params p = exact_wire();
  const double stress_Pa = GetParam() * MPa;
  along_histories(p, stress_Pa, 20, [&](const K::State& s, std::mt19937_64&) {
    const double now = strain_of(p, K::phases(s), stress_Pa);
    // Beyond what heat or cold can do, and the wrong way.
    for (const double goal : {now, -1.0, 1.0}) {
      for (const bool heats : {true, false}) {
        const BranchPoint<double> to = heats ? Inverted::heating(p, s, stress_Pa, goal)
                                             : Inverted::cooling(p, s, stress_Pa, goal);
        ASSERT_GT(to.temperature_K, 0);
        ASSERT_LT(to.temperature_K, 650);
        ASSERT_GE(to.phases.martensite, -0.01);
        ASSERT_GE(to.phases.r_phase, -0.01);
        ASSERT_GE(to.phases.austenite(), -0.01);
      }
    }
    ASSERT_LT(Inverted::heating(p, s, stress_Pa, -1).phases.martensite, 0.03);
  });
}

/// The inverse takes R2M for A2M and R2A for M2A. These lie 13 and 7 K away from them.
TEST(Inverse, SurfacesOfTheirOwnAreBoundedErrors) {
  struct Bound {
    double stress_Pa, cooling, heating;
  };
  Model::Params p = exact_wire();
  p.kinetics = separate_kinetics();
  p.kinetics.smallest_reversal_K = 0;
  for (const Bound& bound : {Bound{50e6, 25, 3}, Bound{150e6, 3, 1}, Bound{400e6, 0.2, 1}}) {
    EXPECT_LT(cooling_errors(p, bound.stress_Pa).worst, bound.cooling);
    EXPECT_LT(heating_errors(p, bound.stress_Pa).worst, bound.heating);
  }
}

/// Without memory a wire has no order, whatever its odds.
TEST(Inverse, OddsMeanNothingWithoutMemory) {
  Model::Params p = exact_wire();
  p.kinetics.memory = Memory::plain;
  Model::Params odd = p;
  odd.kinetics.loop_odds = 30;
  along_histories(p, 150e6, 20, [&](const K::State& s, std::mt19937_64& random) {
    const double now = strain_of(p, K::phases(s), 150e6);
    const double away = 0.02 * uniform(random);
    EXPECT_EQ(Inverted::heating(odd, s, 150e6, now - away).temperature_K,
              Inverted::heating(p, s, 150e6, now - away).temperature_K);
    EXPECT_EQ(Inverted::cooling(odd, s, 150e6, now + away).temperature_K,
              Inverted::cooling(p, s, 150e6, now + away).temperature_K);
  });
}

/// A wire that was so far above A2M that rounding leaves nothing converted, and has just turned.
TEST(Inverse, IsFiniteWhereAlmostNothingHasBeenConverted) {
  Model::Params p = ordered_wire();
  p.kinetics.a2m_a2r.taper = Pair<double>(20);
  p.kinetics.m2a.taper = 20;
  for (const double hot_K : {420.0, 600.0, 1500.0}) {
    K::State s = K::rest(p.kinetics, {300, 100e6});
    K::advance(p.kinetics, s, {hot_K, 100e6});
    K::advance(p.kinetics, s, {hot_K - 5, 100e6});
    const double now = strain_of(p, K::phases(s), 100e6);
    for (const double away : {-0.01, 0.0, 1e-6, 0.01}) {
      const BranchPoint<double> hot = Inverted::heating(p, s, 100e6, now - away);
      const BranchPoint<double> cold = Inverted::cooling(p, s, 100e6, now + away);
      EXPECT_TRUE(std::isfinite(hot.temperature_K + hot.phases.martensite)) << hot_K;
      EXPECT_TRUE(std::isfinite(cold.temperature_K + cold.phases.martensite)) << hot_K;
    }
  }
}

TEST(Inverse, FloatAgreesWithDouble) {
  const Model::Params p = exact_wire();
  const auto pf = benchmarks::convert<float>(p);
  double worst_K = 0;
  along_histories(p, 150e6, 20, [&](const K::State& s, std::mt19937_64& random) {
    const Phases<double> z = K::phases(s);
    const Drive<double> u{K::drive(s).temperature_K, 150e6};
    const K::State from = K::with_phases(p.kinetics, u, z);
    const auto as_float = [](double x) { return static_cast<float>(x); };
    const auto from_f =
        ThreePhase<float>::with_phases(pf.kinetics, {as_float(u.temperature_K), 150e6F},
                                       {as_float(z.martensite), as_float(z.r_phase)});
    const double now = strain_of(p, z, 150e6);
    const double away = 0.01 * uniform(random);
    const double hot = Inverted::heating(p, from, 150e6, now - away).temperature_K;
    const double cold = Inverted::cooling(p, from, 150e6, now + away).temperature_K;
    const float hot_f =
        Inverse<float>::heating(pf, from_f, 150e6F, as_float(now - away)).temperature_K;
    const float cold_f =
        Inverse<float>::cooling(pf, from_f, 150e6F, as_float(now + away)).temperature_K;
    worst_K = std::max({worst_K, std::abs(hot - static_cast<double>(hot_f)),
                        std::abs(cold - static_cast<double>(cold_f))});
  });
  EXPECT_LT(worst_K, 0.2);  // reached in the tails, where the curve is flat
}

}  // namespace
}  // namespace smaservo::test::inverse_test
