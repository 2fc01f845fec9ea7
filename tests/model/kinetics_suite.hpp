#pragma once
// What every hysteresis model must hold: one suite, instantiated for each of them. A subject names
// a model, its parameters and what is promised of it:
//
//   using Model;                         the Kinetics
//   static Model::Params params();
//   static constexpr InnerLoops loops;
//   static constexpr int order;          of the step size on a straight path; for StepOrder
//   static constexpr double rounding;    of a fraction, after some thousand steps

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "model/kinetics.hpp"

namespace smaservo::test {

enum class InnerLoops {
  close,     ///< return-point memory
  ratchet,   ///< plain scaling
  dead_band  ///< plain scaling, but the two directions lie so far apart that ripple does nothing
};

template <class Subject>
class KineticsSuite : public ::testing::Test {
 protected:
  using Model = typename Subject::Model;
  using Real = typename Model::Scalar;
  using State = typename Model::State;
  static_assert(Kinetics<Model>);
  static constexpr bool is_float = sizeof(Real) == sizeof(float);

  static Drive<Real> at(double temperature_K, double stress_MPa) {
    return {static_cast<Real>(temperature_K), static_cast<Real>(1e6 * stress_MPa)};
  }

  void move(State& s, const Drive<Real>& u) const { Model::advance(params, s, u); }

  /// In steps of random size.
  void ramp(State& s, const Drive<Real>& to, int steps) {
    const Drive<Real> from = Model::drive(s);
    std::vector<double> way;
    for (int i = 1; i < steps; ++i) {
      way.push_back(uniform(0, 1));
    }
    std::ranges::sort(way);
    for (const double share : way) {
      const Real part = static_cast<Real>(share);
      move(s, {from.temperature_K + part * (to.temperature_K - from.temperature_K),
               from.stress_Pa + part * (to.stress_Pa - from.stress_Pa)});
    }
    move(s, to);
  }

  /// The next drive of a random walk over 250..450 K and 0..400 MPa: ripple, runs and jumps.
  Drive<Real> wander(const Drive<Real>& u, bool varying_stress = true) {
    const double kind = uniform(0, 1);
    auto T = static_cast<double>(u.temperature_K);
    double stress_MPa = static_cast<double>(u.stress_Pa) / 1e6;
    if (kind < 0.6) {
      T += uniform(-1, 1);
    } else if (kind < 0.75) {
      T = uniform(250, 450);
    } else if (kind < 0.9) {
      stress_MPa += uniform(-30, 30);
    } else {
      T += uniform(-20, 20);
      stress_MPa = uniform(0, 400);
    }
    const Drive<Real> next = at(std::clamp(T, 250.0, 450.0), std::clamp(stress_MPa, 0.0, 400.0));
    return varying_stress ? next : Drive<Real>{next.temperature_K, u.stress_Pa};
  }

  State wandered(int steps, bool varying_stress = true) {
    State s = Model::rest(params, at(uniform(250, 450), uniform(0, 400)));
    for (int i = 0; i < steps; ++i) {
      move(s, wander(Model::drive(s), varying_stress));
    }
    return s;
  }

  static double difference(const State& a, const State& b) {
    const Phases<Real> x = Model::phases(a);
    const Phases<Real> y = Model::phases(b);
    return static_cast<double>(
        std::max({std::abs(x.martensite - y.martensite), std::abs(x.r_phase - y.r_phase),
                  std::abs(x.austenite() - y.austenite())}));
  }

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }

  /// What 100 cycles of +-1 K change of the fractions, worst over stress, temperature and heading.
  double ripple_drift() {
    double worst = 0;
    for (const double stress_MPa : {10.0, 100.0, 200.0, 400.0}) {
      for (double middle_K = 300; middle_K <= 410; middle_K += 2.5) {
        for (const double side_K : {-1.0, 1.0}) {
          State s = Model::rest(params, at(side_K > 0 ? 270 : 450, stress_MPa));
          ramp(s, at(middle_K, stress_MPa), 20);
          State first{};
          for (int cycle = 0; cycle < 100; ++cycle) {
            move(s, at(middle_K + side_K, stress_MPa));
            move(s, at(middle_K - side_K, stress_MPa));
            if (cycle == 0) {
              first = s;
            }
          }
          worst = std::max(worst, difference(s, first));
        }
      }
    }
    return worst;
  }

  typename Model::Params params = Subject::params();
  std::mt19937_64 random{20260102};
};

// For every model.
TYPED_TEST_SUITE_P(KineticsSuite);

/// For models whose steps are exact, whatever their size.
template <class Subject>
class ExactSteps : public KineticsSuite<Subject> {};
TYPED_TEST_SUITE_P(ExactSteps);

/// For those whose steps are not.
template <class Subject>
class StepOrder : public KineticsSuite<Subject> {};
TYPED_TEST_SUITE_P(StepOrder);

/// In double; rounding hides differences of floats.
template <class Subject>
class BranchRates : public KineticsSuite<Subject> {};
TYPED_TEST_SUITE_P(BranchRates);

/// For models with return-point memory.
template <class Subject>
class ReturnPoints : public KineticsSuite<Subject> {};
TYPED_TEST_SUITE_P(ReturnPoints);

/// For sums of relays or plays: history only shifts the martensite of a loop.
template <class Subject>
class CongruentLoops : public KineticsSuite<Subject> {};
TYPED_TEST_SUITE_P(CongruentLoops);

TYPED_TEST_P(KineticsSuite, FractionsStayOnTheSimplex) {
  using K = typename TypeParam::Model;
  using S = typename K::Scalar;
  for (int walk = 0; walk < 100; ++walk) {
    typename K::State s = this->wandered(0);
    for (int i = 0; i < 1000; ++i) {
      this->move(s, this->wander(K::drive(s)));
      const Phases<S> z = K::phases(s);
      const auto min = static_cast<double>(std::min({z.martensite, z.r_phase, z.austenite()}));
      ASSERT_GE(min, -TypeParam::rounding) << "walk " << walk << ", step " << i;
    }
  }
}

TYPED_TEST_P(KineticsSuite, StandingStillChangesNothingToTheBit) {
  using K = typename TypeParam::Model;
  using S = typename K::Scalar;
  for (int walk = 0; walk < 50; ++walk) {
    typename K::State moving = this->wandered(0);
    typename K::State pausing = moving;
    for (int i = 0; i < 500; ++i) {
      const Drive<S> u = this->wander(K::drive(moving));
      this->move(moving, u);
      for (int pause = 0; pause < 3; ++pause) {
        this->move(pausing, u);
      }
      // The next drives would show a difference in the hidden part of the state.
      ASSERT_EQ(K::phases(moving).martensite, K::phases(pausing).martensite) << "step " << i;
      ASSERT_EQ(K::phases(moving).r_phase, K::phases(pausing).r_phase) << "step " << i;
    }
  }
}

TYPED_TEST_P(ExactSteps, OneBigStepEqualsManySmallOnes) {
  using K = typename TypeParam::Model;
  // A step with another stress does not know which process passes its turning point first.
  constexpr bool any_stress = TypeParam::loops != InnerLoops::close;
  double worst = 0;
  for (int i = 0; i < 3000; ++i) {
    typename K::State small = this->wandered(30, any_stress);
    typename K::State big = small;
    const auto from = K::drive(small);
    // Temperature and stress push the same way: one straight run without reversal. The temperature
    // leads, since far outside the transformation stress alone works both ways: it shifts a curve
    // and widens it.
    const double way = this->uniform(-1, 1) < 0 ? -1 : 1;
    const double warmer_K = way * this->uniform(0.5, 60);
    const double T = static_cast<double>(from.temperature_K) + warmer_K;
    const double stress_MPa = std::clamp(
        static_cast<double>(from.stress_Pa) / 1e6 - warmer_K * this->uniform(0, 2), 0.0, 400.0);
    const auto to = any_stress
                        ? this->at(T, stress_MPa)
                        : Drive<typename K::Scalar>{this->at(T, 0).temperature_K, from.stress_Pa};
    this->move(big, to);
    this->ramp(small, to, 50);
    worst = std::max(worst, this->difference(big, small));
  }
  std::printf("worst difference between one step and fifty: %.2g\n", worst);
  EXPECT_LT(worst, TypeParam::rounding);
}

TYPED_TEST_P(StepOrder, ErrorFallsWithTheStepByTheStatedOrder) {
  using K = typename TypeParam::Model;
  for (const double stress_MPa : {10.0, 60.0, 150.0}) {
    const auto cooled = [&](int steps) {
      typename K::State s = K::rest(this->params, this->at(420, stress_MPa));
      for (int i = 1; i <= steps; ++i) {
        this->move(s, this->at(420 - 100.0 * i / steps, stress_MPa));
      }
      return s;
    };
    const typename K::State exact = cooled(1 << 15);
    double before = this->difference(cooled(128), exact);
    EXPECT_LT(before, 2e-3);
    for (int steps = 256; steps <= 1024; steps *= 2) {
      const double now = this->difference(cooled(steps), exact);
      std::printf("%3.0f MPa, %3d steps over 100 K: error %.2g, order %.2f\n", stress_MPa, steps,
                  now, std::log2(before / now));
      EXPECT_NEAR(std::log2(before / now), TypeParam::order, 0.15);
      before = now;
    }
  }
}

TYPED_TEST_P(KineticsSuite, FullCycleErasesHistory) {
  using K = typename TypeParam::Model;
  for (int i = 0; i < 200; ++i) {
    typename K::State a = this->wandered(100);
    typename K::State b = this->wandered(100);
    const double stress_MPa = this->uniform(0, 400);
    const double before = this->difference(a, b);
    // The curves' tails fall off like 1/T: only far outside all temperatures is a cycle full. A
    // memory keeps the outermost turning point, which the tail then fades out.
    const double left = TypeParam::loops == InnerLoops::close ? 5e-4 : 1e-7;
    for (const double T : {3e4, -3e4}) {
      this->move(a, this->at(T, stress_MPa));
      this->move(b, this->at(T, stress_MPa));
    }
    EXPECT_LT(this->difference(a, b), left + TypeParam::rounding) << "before " << before;
    EXPECT_GT(static_cast<double>(K::phases(a).martensite), 0.999);
    for (const double T : {300.0, 360.0, 330.0}) {
      this->move(a, this->at(T, stress_MPa));
      this->move(b, this->at(T, stress_MPa));
      EXPECT_LT(this->difference(a, b), left + 2 * TypeParam::rounding) << "before " << before;
    }
  }
}

TYPED_TEST_P(KineticsSuite, StressTransformsAtConstantTemperature) {
  using K = typename TypeParam::Model;
  const double warm_K = 365;
  typename K::State s = K::rest(this->params, this->at(warm_K, 0));
  const auto martensite = [&] { return static_cast<double>(K::phases(s).martensite); };
  EXPECT_LT(martensite(), 0.1);
  this->ramp(s, this->at(warm_K, 300), 30);
  const double loading = martensite();
  this->ramp(s, this->at(warm_K, 500), 30);
  EXPECT_GT(martensite(), 0.8);
  this->ramp(s, this->at(warm_K, 300), 30);
  EXPECT_GT(martensite(), loading + 0.3);
  this->ramp(s, this->at(warm_K, 0), 30);
  EXPECT_LT(martensite(), 0.1);
}

TYPED_TEST_P(BranchRates, RatesAreTheSlopesOfTheBranch) {
  using K = typename TypeParam::Model;
  using S = typename K::Scalar;
  double largest = 0;
  int wrong = 0;
  for (int i = 0; i < 2000; ++i) {
    typename K::State s = this->wandered(20, false);
    const bool heats = this->uniform(-1, 1) < 0;
    const double sign = heats ? 1 : -1;
    const auto u = K::drive(s);
    const S T = u.temperature_K + static_cast<S>(sign * this->uniform(0.5, 40));
    this->move(s, {T, u.stress_Pa});
    const PhaseRates<S> rates =
        K::rates(this->params, s, heats ? Heading::heating : Heading::cooling);
    const S step = static_cast<S>(sign * 1e-4);
    typename K::State middle = s;
    this->move(middle, {T + step, u.stress_Pa});
    typename K::State end = middle;
    this->move(end, {T + step + step, u.stress_Pa});
    // Forward difference of second order
    const auto slope = [&](S z0, S z1, S z2) {
      return (S(4) * z1 - S(3) * z0 - z2) / (step + step);
    };
    const auto z0 = K::phases(s);
    const auto z1 = K::phases(middle);
    const auto z2 = K::phases(end);
    const S off = std::max(
        std::abs(rates.martensite_1_K - slope(z0.martensite, z1.martensite, z2.martensite)),
        std::abs(rates.r_phase_1_K - slope(z0.r_phase, z1.r_phase, z2.r_phase)));
    wrong += off < S(2e-7) ? 0 : 1;
    largest = std::max(largest, static_cast<double>(std::abs(rates.martensite_1_K)));
  }
  // Hundredths of a kelvin before a turning point the slopes are bounded.
  EXPECT_LE(wrong, 4);
  EXPECT_GT(largest, 0.05);  // some of the branches were steep
}

TYPED_TEST_P(ReturnPoints, ClosedInnerLoopsReturnToTheSamePhases) {
  using K = typename TypeParam::Model;
  double worst = 0;
  double widest = 0;
  for (int i = 0; i < 2000; ++i) {
    const double stress_MPa = this->uniform(0, 400);
    const bool heats = this->uniform(-1, 1) < 0;
    typename K::State s = K::rest(this->params, this->at(heats ? 270 : 450, stress_MPa));
    // Reversals, each within the one before it: up to three loops in each other.
    auto from_K = static_cast<double>(K::drive(s).temperature_K);
    double to_K = this->uniform(290, 420);
    std::vector<typename K::State> turns;
    for (int turn = 0; turn < 6; ++turn) {
      this->ramp(s, this->at(to_K, stress_MPa), 8);
      turns.push_back(s);
      const double next_K = to_K + (from_K - to_K) * this->uniform(0.3, 0.7);
      from_K = to_K;
      to_K = next_K;
    }
    // Outwards through the turning points: 5 -> 4 -> 5's loop closes at 4's, and so on.
    for (std::size_t turn = 4; turn-- > 0;) {
      this->ramp(s, K::drive(turns[turn]), 8);
      worst = std::max(worst, this->difference(s, turns[turn]));
      widest = std::max(widest, this->difference(turns[turn], turns[turn + 1]));
    }
  }
  std::printf("worst gap of an inner loop: %.2g\n", worst);
  EXPECT_LT(worst, TypeParam::rounding);
  EXPECT_GT(widest, 0.3);
}

TYPED_TEST_P(ReturnPoints, ClosedStressLoopsReturnToTheSamePhases) {
  using K = typename TypeParam::Model;
  double worst = 0;
  for (int i = 0; i < 1000; ++i) {
    const double T = this->uniform(310, 390);
    const double outer_MPa = this->uniform(150, 400);
    typename K::State s = K::rest(this->params, this->at(T, 0));
    this->ramp(s, this->at(T, outer_MPa), 8);
    const typename K::State turn = s;
    this->ramp(s, this->at(T, outer_MPa * this->uniform(0, 0.9)), 8);
    this->ramp(s, this->at(T, outer_MPa), 8);
    worst = std::max(worst, this->difference(s, turn));
  }
  std::printf("worst gap of a stress loop: %.2g\n", worst);
  EXPECT_LT(worst, 1e-6);
}

TYPED_TEST_P(KineticsSuite, RippleMovesTheFractionsOnlyWithoutMemory) {
  const double drift = this->ripple_drift();
  std::printf("100 cycles of +-1 K move the fractions by %.2g\n", drift);
  if (TypeParam::loops == InnerLoops::ratchet) {
    EXPECT_GT(drift, 0.05);
  } else {
    EXPECT_LT(drift, 1e-3);
  }
}

TYPED_TEST_P(CongruentLoops, LoopsBetweenTheSameTemperaturesAreCongruent) {
  using K = typename TypeParam::Model;
  double widest = 0;
  double apart = 0;
  for (int i = 0; i < 300; ++i) {
    const double stress_MPa = this->uniform(0, 400);
    const double low_K = this->uniform(300, 380);
    const double high_K = low_K + this->uniform(5, 40);
    const auto loop = [&] {
      typename K::State s = this->wandered(30);
      this->move(s, this->at(low_K, stress_MPa));
      this->move(s, this->at(high_K, stress_MPa));
      std::vector<double> way;
      for (int step = 0; step <= 40; ++step) {
        const double share = step <= 20 ? 1 - step / 20.0 : step / 20.0 - 1;
        this->move(s, this->at(low_K + share * (high_K - low_K), stress_MPa));
        way.push_back(K::phases(s).martensite);
      }
      return way;
    };
    const std::vector<double> a = loop();
    const std::vector<double> b = loop();
    apart = std::max(apart, std::abs(a[0] - b[0]));
    for (std::size_t step = 0; step < a.size(); ++step) {
      widest = std::max(widest, std::abs(a[step] - a[0]));
      ASSERT_NEAR(a[step] - a[0], b[step] - b[0], 1e-12) << i;
    }
  }
  EXPECT_GT(widest, 0.3);
  EXPECT_GT(apart, 0.3);  // loops of different histories
}

REGISTER_TYPED_TEST_SUITE_P(KineticsSuite, FractionsStayOnTheSimplex,
                            StandingStillChangesNothingToTheBit, FullCycleErasesHistory,
                            StressTransformsAtConstantTemperature,
                            RippleMovesTheFractionsOnlyWithoutMemory);
REGISTER_TYPED_TEST_SUITE_P(ExactSteps, OneBigStepEqualsManySmallOnes);
REGISTER_TYPED_TEST_SUITE_P(StepOrder, ErrorFallsWithTheStepByTheStatedOrder);
REGISTER_TYPED_TEST_SUITE_P(BranchRates, RatesAreTheSlopesOfTheBranch);
REGISTER_TYPED_TEST_SUITE_P(ReturnPoints, ClosedInnerLoopsReturnToTheSamePhases,
                            ClosedStressLoopsReturnToTheSamePhases);
REGISTER_TYPED_TEST_SUITE_P(CongruentLoops, LoopsBetweenTheSameTemperaturesAreCongruent);

}  // namespace smaservo::test
