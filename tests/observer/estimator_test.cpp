#include "observer/estimator.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "tests/bench/convert.hpp"
#include "tests/observer/shipped_traces.hpp"

namespace smaservo::estimator_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

using Bits = std::array<std::uint64_t, 6>;
Bits bits(const Estimate<double>& e) {
  return std::bit_cast<Bits>(std::array{e.strain, e.strain_sd, e.temperature_K, e.martensite,
                                        e.r_phase, e.resistance_model_ohm});
}

bool is_unknown(const Estimate<double>& e) {
  return std::isnan(e.strain) && std::isnan(e.strain_sd) && std::isnan(e.temperature_K) &&
         e.health == Health::doubtful;
}

TEST(Estimator, IsTheFilterToTheBit) {
  using Observer = Substepping<MultipleModelFilter<double>>;
  for (const ShippedTrace& trace : shipped_traces()) {
    const Wire<double> wire = load_unit(trace);
    const Observer::Params p{plant_params(wire), kalman_tuning(wire.accuracy)};
    Estimator estimator{wire};
    Observer::State state{};
    bool first = true;
    for (const TraceStep& step : load_trace(trace)) {
      const Measurement<double> m = measure(good_front_end(wire), step.sample);
      if (first) {
        Observer::start(p, state, m, room_K);
        first = false;
      } else {
        Observer::advance(p, state, m, step.dt_s);
      }
      ASSERT_EQ(bits(estimator.update(step.sample, step.dt_s)), bits(Observer::estimate(p, state)));
    }
  }
}

TEST(Estimator, ACopyIsASavedState) {
  const ShippedTrace trace = shipped_traces().front();
  Estimator estimator{load_unit(trace)};
  const std::vector<TraceStep> steps = load_trace(trace);
  for (std::size_t i = 0; i < 3000; ++i) {
    estimator.update(steps[i].sample, steps[i].dt_s);
  }
  Estimator copy = estimator;
  for (std::size_t i = 3000; i < 6000; ++i) {
    ASSERT_EQ(bits(estimator.update(steps[i].sample, steps[i].dt_s)),
              bits(copy.update(steps[i].sample, steps[i].dt_s)));
  }
}

TEST(Estimator, NothingIsKnownBeforeTheFirstLoad) {
  const ShippedTrace trace = shipped_traces().front();
  Estimator estimator{load_unit(trace)};
  EXPECT_TRUE(
      is_unknown(estimator.update({.current_A = 0.1, .voltage_V = 2, .load_N = nan}, 1e-3)));
  EXPECT_FALSE(estimator.started());
  Estimator fresh{load_unit(trace)};
  for (const TraceStep& step : load_trace(trace)) {
    ASSERT_EQ(bits(estimator.update(step.sample, step.dt_s)),
              bits(fresh.update(step.sample, step.dt_s)));
  }
}

TEST(Estimator, AnAirSensorThatHasFailedIsAsNone) {
  const ShippedTrace trace = shipped_traces().front();
  Estimator none{load_unit(trace)};
  for (const double air_K : {nan, std::numeric_limits<double>::infinity()}) {
    Estimator failed{load_unit(trace), air_K};
    none.restart();
    for (const TraceStep& step : load_trace(trace)) {
      ASSERT_EQ(bits(failed.update(step.sample, step.dt_s)),
                bits(none.update(step.sample, step.dt_s)));
    }
  }
}

/// An interval that is none changes nothing; a gap of more than a minute starts anew.
TEST(Estimator, IntervalsThatAreNone) {
  const ShippedTrace trace = shipped_traces().front();
  const std::vector<TraceStep> steps = load_trace(trace);
  Estimator estimator{load_unit(trace)};
  Estimator undisturbed = estimator;
  for (std::size_t i = 0; i < 4000; ++i) {
    ASSERT_EQ(bits(estimator.update(steps[i].sample, steps[i].dt_s)),
              bits(undisturbed.update(steps[i].sample, steps[i].dt_s)));
    for (const double dt_s : {0.0, -1e-3, nan, -std::numeric_limits<double>::infinity()}) {
      ASSERT_TRUE(is_unknown(estimator.update(steps[i].sample, dt_s)));
    }
  }
  Estimator fresh{load_unit(trace)};
  for (std::size_t i = 0; i < 1000; ++i) {
    const double gap_s = i == 0 ? 61 : steps[i].dt_s;
    ASSERT_EQ(bits(estimator.update(steps[i].sample, gap_s)),
              bits(fresh.update(steps[i].sample, gap_s)));
  }
}

/// Whatever it is given: numbers or unknown, no hang; and after restart() nothing of it is left.
TEST(Estimator, SurvivesAnyReading) {
  const ShippedTrace trace = shipped_traces().front();
  const std::vector<TraceStep> steps = load_trace(trace);
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const auto odd = std::to_array({0.0, -1.0, nan, infinite, -infinite, 1e300, 1e-300, 1e9, -0.0});
  std::mt19937_64 random(7);
  const auto pick = [&](double usual) {
    return random() % 4 == 0 ? odd.at(random() % odd.size()) : usual;
  };
  Estimator estimator{load_unit(trace)};
  int unknown = 0;
  for (std::size_t i = 0; i < 20000; ++i) {
    const TraceStep& step = steps[i % steps.size()];
    const Sample<double> s{pick(step.sample.current_A), pick(step.sample.voltage_V),
                           pick(step.sample.load_N)};
    const Estimate<double> e =
        estimator.update(s, random() % 10 == 0 ? odd.at(random() % odd.size()) : 1e-3);
    unknown += is_unknown(e) ? 1 : 0;
    ASSERT_TRUE(is_unknown(e) || std::isfinite(e.strain + e.strain_sd + e.temperature_K));
  }
  EXPECT_GT(unknown, 0);
  EXPECT_LT(unknown, 20000);
  estimator.restart();
  Estimator fresh{load_unit(trace)};
  for (std::size_t i = 0; i < 2000; ++i) {
    ASSERT_EQ(bits(estimator.update(steps[i].sample, steps[i].dt_s)),
              bits(fresh.update(steps[i].sample, steps[i].dt_s)));
  }
}

TEST(Estimator, IsNearlyTheSameInSinglePrecision) {
  const ShippedTrace trace = shipped_traces().front();
  const Wire<double> wire = load_unit(trace);
  Estimator exact{wire};
  Estimator single{benchmarks::convert<float>(wire)};
  double worst = 0;
  for (const TraceStep& step : load_trace(trace)) {
    const double strain = exact.update(step.sample, step.dt_s).strain;
    const float other = single
                            .update({static_cast<float>(step.sample.current_A),
                                     static_cast<float>(step.sample.voltage_V),
                                     static_cast<float>(step.sample.load_N)},
                                    static_cast<float>(step.dt_s))
                            .strain;
    worst = std::max(worst, std::abs(strain - static_cast<double>(other)));
  }
  EXPECT_LT(worst, 0.0004);  // 1 % of a 4 % stroke
  EXPECT_GT(worst, 0);
}

}  // namespace
}  // namespace smaservo::estimator_test
