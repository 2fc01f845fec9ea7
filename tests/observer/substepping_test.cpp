#include "observer/substepping.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <limits>

#include "observer/kalman.hpp"
#include "tests/observer/simulated_wire.hpp"

namespace smaservo::substepping_test {
namespace {

using Filter = KalmanObserver<double>;
using Slow = Substepping<Filter>;
static_assert(StrainObserver<Slow>);
static_assert(StrainObserver<Substepping<KalmanObserver<float>>>);

constexpr double stress_Pa = 200e6;

Filter::Params tuned() {
  return {plant_params(bench_wire()), {}};
}

Measurement<double> step_of(LumpedWire& wire, Profile& profile, int i) {
  return wire.step(profile.power_W(i * sample_s));
}

TEST(Substepping, IsTheObserverItselfForFastSamples) {
  const Filter::Params p = tuned();
  LumpedWire wire({}, stress_Pa, 1);
  Profile profile(stress_Pa, 2);
  const Measurement<double> first = wire.step(0);
  Filter::State plain = Filter::start(p, first, told_ambient_K);
  Slow::State substepped = Slow::start(p, first, told_ambient_K);
  for (int i = 0; i < 5000; ++i) {
    const Measurement<double> m = step_of(wire, profile, i);
    // The steps jitter around the longest step, which must change nothing.
    const double dt_s = i % 2 == 0 ? 6.3e-3 : 3.7e-3;
    Filter::advance(p, plain, m, dt_s);
    Slow::advance(p, substepped, m, dt_s);
    ASSERT_EQ(std::bit_cast<std::uint64_t>(Filter::estimate(p, plain).strain),
              std::bit_cast<std::uint64_t>(Slow::estimate(p, substepped).strain));
  }
}

/// Mean error in % of the stroke if the observer gets only one of fifty samples.
template <StrainObserver O>
double error_at_20_Hz() {
  const typename O::Params p = tuned();
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    LumpedWire wire({}, stress_Pa, seed);
    Profile profile(stress_Pa, seed + 10);
    typename O::State s = O::start(p, wire.step(0), told_ambient_K);
    for (int i = 0; i < 30000; ++i) {
      const Measurement<double> m = step_of(wire, profile, i);
      if (i % 50 == 49) {
        O::advance(p, s, m, 50 * sample_s);
        sum += 2500 * std::abs(O::estimate(p, s).strain - wire.strain());
        ++count;
      }
    }
  }
  return sum / count;
}

TEST(Substepping, IsBetterThanOneLongStep) {
  const double substepped = error_at_20_Hz<Slow>();
  const double one_step = error_at_20_Hz<Filter>();
  RecordProperty("substepping_percent", std::to_string(substepped));
  RecordProperty("one_step_percent", std::to_string(one_step));
  EXPECT_LT(substepped, 0.9 * one_step);
  EXPECT_GT(substepped, 0.05);
  EXPECT_LT(substepped, 1.0);
}

TEST(Substepping, DoesNotBridgeWhatIsInvalidAtOneEnd) {
  const Filter::Params p = tuned();
  LumpedWire wire({}, stress_Pa, 1);
  const Measurement<double> good = wire.step(0);
  Measurement<double> bad{};
  bad.resistance_ohm = std::numeric_limits<double>::quiet_NaN();
  bad.stress_Pa = std::numeric_limits<double>::quiet_NaN();
  Slow::State s = Slow::start(p, good, told_ambient_K);
  for (int i = 0; i < 100; ++i) {
    Slow::advance(p, s, i % 2 == 0 ? bad : good, 0.020);
    ASSERT_TRUE(std::isfinite(Slow::estimate(p, s).strain)) << i;
  }
}

TEST(Substepping, AMinuteIsBoundedWork) {
  const Filter::Params p = tuned();
  LumpedWire wire({}, stress_Pa, 1);
  const Measurement<double> m = wire.step(0);
  Slow::State s = Slow::start(p, m, told_ambient_K);
  Slow::advance(p, s, m, 60.0);
  EXPECT_NEAR(Slow::estimate(p, s).temperature_K, told_ambient_K, 3);
  EXPECT_NEAR(Slow::estimate(p, s).strain, wire.strain(), 0.02 * 0.04);
}

}  // namespace
}  // namespace smaservo::substepping_test
