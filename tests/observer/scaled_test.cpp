// Compares model and observer in integer arithmetic (model/scalar/scaled.hpp) with those in double,
// over the project's traces and random ones.

#include "model/scalar/scaled.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

#include "observer/multiple_model.hpp"
#include "observer/open_loop.hpp"
#include "observer/substepping.hpp"
#include "tests/bench/convert_observer.hpp"
#include "tests/observer/shipped_traces.hpp"

namespace smaservo::scaled_test {
namespace {

using benchmarks::convert;

constexpr double ambient_K = room_K;

struct Recorded {
  std::string name;
  Wire<double> wire;
  std::vector<TraceStep> steps;
};

/// A wire that is heated, loaded and cooled at random, behind noisy sensors.
Recorded random_run(unsigned seed) {
  using Model = Plant<ThreePhase<double>>;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> share;
  std::normal_distribution<double> noise;
  Recorded run{"random " + std::to_string(seed), load_unit({"", seed % 2 == 0 ? "a" : "b"}), {}};
  const Model::Params params = plant_params(run.wire);
  const double air_K = ambient_K + 5 * noise(random);
  const double area_m2 = run.wire.geometry.area_m2();
  double stress_Pa = 1e6 * std::exp(std::log(10) + share(random) * std::log(40));
  Model::State wire = Model::rest(params, {air_K, stress_Pa});
  double current_A = 0.02;
  double goal_Pa = stress_Pa;
  const double dt_s = seed % 3 == 0 ? 1e-3 : seed % 3 == 1 ? 2e-3 : 1e-2;
  for (int i = 0; i < 6000; ++i) {
    if (i % 200 == 0) {
      const double hot_W = params.body.loss_W(40 + 90 * share(random));
      current_A = std::max(0.012, std::sqrt(share(random) * 1.5 * hot_W /
                                            Model::resistance_ohm(params, wire, air_K)));
      goal_Pa = share(random) < 0.3 ? 1e6 * (10 + 390 * share(random)) : goal_Pa;
    }
    stress_Pa += 0.01 * (goal_Pa - stress_Pa);
    const double ohm = Model::resistance_ohm(params, wire, air_K);
    Model::advance(params, wire, {current_A * current_A * ohm, stress_Pa, air_K}, dt_s);
    run.steps.push_back({{current_A + 1e-5 * noise(random), current_A * ohm + 3e-4 * noise(random),
                          stress_Pa * area_m2 * (1 + 0.002 * noise(random))},
                         dt_s});
  }
  return run;
}

std::vector<Recorded> all_runs() {
  std::vector<Recorded> runs;
  for (const ShippedTrace& trace : shipped_traces()) {
    runs.push_back({trace.name, load_unit(trace), load_trace(trace)});
  }
  for (unsigned seed = 1; seed <= 12; ++seed) {
    runs.push_back(random_run(seed));
  }
  return runs;
}

/// Differences in % of the nominal stroke.
struct Deviation {
  double mean = 0;
  double max = 0;
  std::size_t count = 0;

  void add(double strain, double exact, double stroke) {
    const double percent = 100 * std::abs(strain - exact) / stroke;
    mean += percent;
    max = std::max(max, percent);
    ++count;
  }
};

/// Differences of the strain by kinetics and mixture in Scaled from that in double. Both get the
/// temperatures and stresses of a wire that is simulated in double.
Deviation model_deviation(const Recorded& run) {
  using Exact = Plant<ThreePhase<double>>;
  using K = ThreePhase<Scaled>;
  const Exact::Params exact = plant_params(run.wire);
  const Plant<K>::Params params = convert<Scaled>(exact);
  const MeasurementParams<double> measurement = measurement_params(run.wire);
  const auto first = measure(measurement, run.steps.front().sample);
  Exact::State wire = Exact::rest(exact, {ambient_K, first.stress_Pa});
  ThreePhase<double>::State way = wire.kinetics;
  K::State state = K::rest(params.kinetics, {Scaled(ambient_K), Scaled::of(first.stress_Pa)});
  Deviation deviation;
  for (const TraceStep& step : run.steps) {
    const auto m = measure(measurement, step.sample);
    Exact::advance(exact, wire, {m.power_W, m.stress_Pa, ambient_K}, std::max(step.dt_s, 1e-5));
    const Drive<double> to = ThreePhase<double>::drive(wire.kinetics);
    const Drive<Scaled> scaled{Scaled::of(to.temperature_K), Scaled::of(to.stress_Pa)};
    K::advance(params.kinetics, state, scaled);
    ThreePhase<double>::advance(exact.kinetics, way, to);
    const Scaled elongation = strain(params.material, K::phases(state), scaled.stress_Pa);
    EXPECT_TRUE(isfinite(elongation));
    deviation.add(static_cast<double>(elongation),
                  strain(exact.material, ThreePhase<double>::phases(way), to.stress_Pa),
                  run.wire.nominal_stroke);
  }
  deviation.mean /= static_cast<double>(deviation.count);
  return deviation;
}

template <class S>
std::vector<Estimate<S>> estimates(const Recorded& run) {
  using O = Substepping<MultipleModelFilter<S>>;
  const typename O::Params params{convert<S>(plant_params(run.wire)),
                                  convert<S>(kalman_tuning(run.wire.accuracy))};
  const MeasurementParams<S> measurement = convert<S>(measurement_params(run.wire));
  const auto measured = [&](const TraceStep& step) {
    return measure(measurement, convert<S>(step.sample));
  };
  typename O::State state = O::start(params, measured(run.steps.front()), S(ambient_K));
  std::vector<Estimate<S>> all;
  for (std::size_t i = 1; i < run.steps.size(); ++i) {
    O::advance(params, state, measured(run.steps[i]), scalar<S>(run.steps[i].dt_s));
    all.push_back(O::estimate(params, state));
  }
  return all;
}

Deviation observer_deviation(const Recorded& run) {
  const auto exact = estimates<double>(run);
  const auto scaled = estimates<Scaled>(run);
  Deviation deviation;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const Estimate<Scaled>& e = scaled[i];
    EXPECT_TRUE(isfinite(e.strain + e.strain_sd + e.temperature_K + e.resistance_model_ohm)) << i;
    deviation.add(static_cast<double>(e.strain), exact[i].strain, run.wire.nominal_stroke);
  }
  deviation.mean /= static_cast<double>(deviation.count);
  return deviation;
}

TEST(ScaledTraces, TheModelIsThatOfADouble) {
  for (const Recorded& run : all_runs()) {
    EXPECT_LT(model_deviation(run).max, 1e-3) << run.name;
  }
}

// A step of the heat balance does not know at which temperature the transformation continues. After
// a step that transforms nothing it overshoots, and then the smallest difference grows tenfold in
// each of some steps. Two observers in double that differ by their last bit deviate as far.
TEST(ScaledTraces, TheObserverIsThatOfADouble) {
  for (const Recorded& run : all_runs()) {
    const Deviation deviation = observer_deviation(run);
    EXPECT_LT(deviation.mean, 0.1) << run.name;
    EXPECT_LT(deviation.max, 3) << run.name;
  }
}

}  // namespace
}  // namespace smaservo::scaled_test
