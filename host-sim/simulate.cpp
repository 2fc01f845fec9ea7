#include "host-sim/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <random>

#include "model/distributed.hpp"

namespace smaservo {
namespace {

// Deep enough for the tiny loops that noise of the load makes inside the great ones.
using K = ThreePhase<double, 24>;
constexpr int segments = 24;
using Distributed = DistributedPlant<K, segments>;
constexpr double step_s = 1e-3;

/// Short segments at the clamps, where the temperature changes, long ones in the middle.
Distributed::Params distribute(const Scenario& scenario, std::mt19937_64& random) {
  const Wire<double>& wire = scenario.wire.wire;
  Distributed::Params p{};
  p.material = wire.material;
  p.heat = wire.heat;
  p.geometry = wire.geometry;
  double sum = 0;
  for (int i = 0; i < segments; ++i) {
    p.length_m[static_cast<std::size_t>(i)] = std::pow(1.5, std::min(i, segments - 1 - i));
    sum += p.length_m[static_cast<std::size_t>(i)];
  }
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < segments; ++i) {
    p.length_m[i] *= wire.geometry.length_m / sum;
    const double warmer_K = scenario.scatter_K * normal(random);
    K::Params& k = p.kinetics[i];
    k = wire.kinetics;
    k.smallest_reversal_K = 0;
    const auto shift = [&](auto& surface, auto by) {
      surface.start_K[0] = surface.start_K[0] + by;
      surface.finish_K[0] = surface.finish_K[0] + by;
    };
    shift(k.m2a, warmer_K);
    shift(k.a2m_a2r, Pair<double>(warmer_K));
    shift(k.r2a, warmer_K);
    shift(k.r2m, warmer_K);
  }
  return p;
}

/// The load's next stress, from the strain before.
class LoadModel {
 public:
  explicit LoadModel(const Load& load) : load_(load) {
    if (const auto* constant = std::get_if<ConstantLoad>(&load_)) {
      stress_Pa_ = constant->stress_Pa;
    } else if (const auto* spring = std::get_if<SpringLoad>(&load_)) {
      stress_Pa_ = spring->low_Pa;
    } else {
      stress_Pa_ = std::get<VaryingLoad>(load_).stress_Pa;
    }
  }

  double stress_Pa() const { return stress_Pa_; }

  void advance(double time_s, double strain, std::mt19937_64& random) {
    if (const auto* spring = std::get_if<SpringLoad>(&load_)) {
      longest_ = std::isnan(longest_) ? strain : longest_;
      const double share = std::clamp((longest_ - strain) / spring->stroke, 0.0, 1.0);
      const double goal = spring->low_Pa + share * (spring->high_Pa - spring->low_Pa);
      stress_Pa_ += (goal - stress_Pa_) * step_s / spring->lag_s;
    } else if (const auto* varying = std::get_if<VaryingLoad>(&load_)) {
      std::normal_distribution<double> normal;
      walk_Pa_ += varying->walk_Pa * std::sqrt(step_s) * normal(random) - walk_Pa_ * step_s / 3;
      const double wave = std::sin(2 * std::numbers::pi * time_s / varying->period_s);
      stress_Pa_ =
          std::max(varying->least_Pa, varying->stress_Pa + varying->amplitude_Pa * wave + walk_Pa_);
    }
  }

 private:
  Load load_;
  double stress_Pa_ = 0;
  double walk_Pa_ = 0;
  double longest_ = std::numeric_limits<double>::quiet_NaN();
};

double quantised(double value, double full_scale, int bits) {
  const double step = full_scale / std::ldexp(1.0, bits - 1);
  return std::clamp(std::round(value / step) * step, -full_scale, full_scale);
}

void run_joule(const Scenario& scenario, const JouleScenario& joule, OutputFile& trace) {
  const Wire<double>& wire = scenario.wire.wire;
  std::mt19937_64 random(scenario.seed + 1);
  std::normal_distribution<double> normal;
  const Distributed::Params plant = distribute(scenario, random);
  LoadModel load(joule.load);
  auto state = Distributed::rest(plant, {joule.ambient_K, load.stress_Pa()});
  // What the lumped balance says is needed; the plant does as it likes.
  const auto body = thermal_body(wire.geometry, wire.heat);
  const double hottest_K = [&] {
    const Isobar<double> m2a = isobar(wire.kinetics.m2a, load.stress_Pa());
    return m2a.start_K + 1 / m2a.per_K + joule.overheat_K;
  }();
  trace.write("time_s,current_A,voltage_V,load_N,strain_ref\n");
  const long every = std::lround(1 / (joule.rate_Hz * step_s));
  long tick = 0;
  for (const DriveStep& step : joule.drive) {
    const double power_W = step.level * body.loss_W(hottest_K - 298.15);
    for (const long stop = tick + std::lround(step.seconds / step_s); tick < stop; ++tick) {
      const double time_s = static_cast<double>(tick) * step_s;
      const double strain = Distributed::strain(plant, state);
      load.advance(time_s, strain, random);
      const double ohm = Distributed::resistance_ohm(plant, state);
      const double current_A = std::max(std::sqrt(power_W / ohm), joule.least_current_A);
      const Sensors& s = joule.sensors;
      const double I =
          quantised(current_A + s.current_noise_A * normal(random), s.current_full_scale_A, s.bits);
      const double V =
          quantised(current_A * ohm * s.resistance_gain + s.voltage_noise_V * normal(random),
                    s.voltage_full_scale_V, s.bits);
      const double F = quantised(load.stress_Pa() * wire.geometry.area_m2() * s.load_gain +
                                     s.load_noise_N * normal(random),
                                 s.load_full_scale_N, s.bits);
      if (tick % every == 0 && time_s >= joule.record_from_s) {
        trace.write(fmt::format("{:.3f},{:.6f},{:.5f},{:.4f},{:.6f}\n",
                                time_s - joule.record_from_s, I, V, F, strain));
      }
      Distributed::advance(plant, state, current_A, {load.stress_Pa(), joule.ambient_K},
                           joule.draught, step_s);
    }
  }
}

void run_bath(const Scenario& scenario, const BathScenario& bath, OutputFile& trace) {
  std::mt19937_64 random(scenario.seed + 1);
  std::normal_distribution<double> normal;
  const Distributed::Params plant = distribute(scenario, random);
  std::array<K::State, segments> states;
  double T = bath.turning_K.front();
  for (std::size_t i = 0; i < segments; ++i) {
    states[i] = K::rest(plant.kinetics[i], {T, bath.stress_Pa});
  }
  trace.write("temperature_degC,stress_MPa,strain_ref\n");
  const auto record = [&] {
    double elongation = 0;
    for (std::size_t i = 0; i < segments; ++i) {
      K::advance(plant.kinetics[i], states[i], {T, bath.stress_Pa});
      elongation += strain(plant.material, K::phases(states[i]), bath.stress_Pa) *
                    plant.length_m[i] / plant.geometry.length_m;
    }
    trace.write(fmt::format("{:.3f},{:.3f},{:.6f}\n",
                            T - 273.15 + bath.temperature_noise_K * normal(random),
                            bath.stress_Pa * 1e-6, elongation));
  };
  record();
  for (const double goal_K : bath.turning_K) {
    while (std::abs(goal_K - T) > 1e-9) {
      T += std::clamp(goal_K - T, -bath.step_K, bath.step_K);
      record();
    }
  }
}

}  // namespace

void simulate(const Scenario& scenario, OutputFile& trace) {
  if (const auto* joule = std::get_if<JouleScenario>(&scenario.run)) {
    run_joule(scenario, *joule, trace);
  } else {
    run_bath(scenario, std::get<BathScenario>(scenario.run), trace);
  }
}

}  // namespace smaservo
