#pragma once
// Runs in a calorimeter, in a bath and heated by current as a laboratory would measure them, of a
// wire that the tests know.

#include <cmath>
#include <random>
#include <vector>

#include "host-sim/identify/runs/run.hpp"
#include "model/wire/plant.hpp"
#include "model/wire/wire_plant.hpp"

namespace smaservo::test {

using Model = ThreePhase<double>;

inline constexpr double rate_K_s = 10.0 / 60;

inline std::vector<double> cycle_K() {
  std::vector<double> all;
  for (double T = 293; T < 400; T += 0.5) {
    all.push_back(T);
  }
  for (double T = 400; T > 293; T -= 0.5) {
    all.push_back(T);
  }
  return all;
}

inline identify::Run calorimetry_run(const Wire<double>& wire, std::mt19937_64& random) {
  std::normal_distribution<double> noise_W_kg(0, 3);
  identify::Run run{};
  run.name = "calorimetry";
  run.kind = identify::RunKind::calorimetry;
  run.temperature_K = cycle_K();
  auto state = Model::rest(wire.kinetics, {run.temperature_K.front(), 0});
  double before_K = run.temperature_K.front() - 0.5;
  for (const double T : run.temperature_K) {
    const Phases<double> before = Model::phases(state);
    Model::advance(wire.kinetics, state, {T, 0});
    const Phases<double> after = Model::phases(state);
    const double taken_J_kg = wire.heat.specific_heat_J_kgK * (T - before_K) -
                              wire.heat.latent_m2a_J_kg * (after.martensite - before.martensite) -
                              wire.heat.latent_r2a_J_kg * (after.r_phase - before.r_phase);
    run.power_W_kg.push_back(taken_J_kg * rate_K_s / std::abs(T - before_K) + noise_W_kg(random));
    before_K = T;
  }
  run.stress_Pa.assign(run.temperature_K.size(), 0.0);
  return run;
}

inline identify::Run bath_run(const Wire<double>& wire, double stress_Pa, std::mt19937_64& random,
                              const std::vector<double>& temperature_K = cycle_K()) {
  std::normal_distribution<double> noise(0, 2e-5);
  auto params = plant_params(wire);
  params.ends.share = 0;
  identify::Run run{};
  run.name = "bath";
  run.kind = identify::RunKind::bath;
  run.temperature_K = temperature_K;
  auto state = Plant<Model>::rest(params, {run.temperature_K.front(), stress_Pa});
  for (const double T : run.temperature_K) {
    Model::advance(params.kinetics, state.kinetics, {T, stress_Pa});
    run.strain.push_back(Plant<Model>::strain(params, state) + noise(random));
  }
  run.stress_Pa.assign(run.temperature_K.size(), stress_Pa);
  return run;
}

/// A cycle and some steps of the current, 24 s at 50 rows/s.
inline identify::Run joule_run(const Wire<double>& wire, double load_Pa, std::mt19937_64& random) {
  std::uniform_real_distribution<double> level(0.1, 0.75);
  std::normal_distribution<double> noise;
  const double load_N = load_Pa * wire.geometry.area_m2();
  const double hot_A = (1 + 0.3 * load_Pa / 400e6) * wire.limits.current_A;
  WirePlant plant(wire, load_N);
  identify::Run run{};
  run.name = "joule";
  run.kind = identify::RunKind::joule;
  double current_A = 0;
  for (int i = 0; i < 1200; ++i) {
    const double t_s = 0.02 * i;
    if (t_s < 10) {
      current_A = std::fmod(t_s, 10) < 5 ? hot_A : 0.1 * hot_A;
    } else if (i % 50 == 0) {
      current_A = hot_A * std::sqrt(level(random));
    }
    const WireOutput<double> now = plant.update({.current_A = current_A, .load_N = load_N}, 0.02);
    run.time_s.push_back(t_s);
    run.current_A.push_back(current_A);
    run.voltage_V.push_back(current_A * now.resistance_ohm * (1 + 1e-4 * noise(random)));
    run.resistance_ohm.push_back(run.voltage_V.back() / current_A);
    run.strain.push_back(now.strain + 2e-5 * noise(random));
    run.stress_Pa.push_back(load_Pa);
  }
  return run;
}

}  // namespace smaservo::test
