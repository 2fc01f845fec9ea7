// Calorimetry and baths in one fit.

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "host-sim/identify/fit/fit.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/wire/plant.hpp"

namespace smaservo::test {
namespace {

using Model = ThreePhase<double>;

constexpr double rate_K_s = 10.0 / 60;

/// The preset, but for what calorimetry sees best and baths do not see at all.
Wire<double> truth() {
  Wire<double> wire = files::load_wire("smartflex-76um").wire;
  wire.kinetics.m2a.start_K[0] += 4;
  wire.kinetics.m2a.finish_K[0] += 4;
  wire.heat.latent_m2a_J_kg *= 1.2;
  wire.heat.specific_heat_J_kgK *= 1.08;
  wire.material.martensite.strain += 0.004;
  return wire;
}

std::vector<double> cycle_K() {
  std::vector<double> all;
  for (double T = 293; T < 400; T += 0.5) {
    all.push_back(T);
  }
  for (double T = 400; T > 293; T -= 0.5) {
    all.push_back(T);
  }
  return all;
}

identify::Run calorimetry(const Wire<double>& wire, std::mt19937_64& random) {
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

identify::Run bath(const Wire<double>& wire, double stress_Pa, std::mt19937_64& random) {
  std::normal_distribution<double> noise(0, 2e-5);
  auto params = plant_params(wire);
  params.ends.share = 0;
  identify::Run run{};
  run.name = "bath";
  run.kind = identify::RunKind::bath;
  run.temperature_K = cycle_K();
  auto state = Plant<Model>::rest(params, {run.temperature_K.front(), stress_Pa});
  for (const double T : run.temperature_K) {
    Model::advance(params.kinetics, state.kinetics, {T, stress_Pa});
    run.strain.push_back(Plant<Model>::strain(params, state) + noise(random));
  }
  run.stress_Pa.assign(run.temperature_K.size(), stress_Pa);
  return run;
}

std::vector<identify::Run> runs(const Wire<double>& wire) {
  std::mt19937_64 random(5);
  std::vector<identify::Run> all{calorimetry(wire, random)};
  for (const double stress_Pa : {20e6, 100e6, 250e6}) {
    all.push_back(bath(wire, stress_Pa, random));
  }
  return all;
}

TEST(Calorimetry, AndBathsAreExplainedTogether) {
  const Wire<double> wire = truth();
  std::vector<smaservo::identify::Run> all = runs(wire);
  all.front().power_W_kg[100] = std::numeric_limits<double>::quiet_NaN();
  identify::FitOptions options;
  options.variants = false;
  const identify::FitResult fit =
      identify::fit_wire(files::load_wire("smartflex-76um").wire, all, options);
  for (const identify::FittedRun& run : fit.runs) {
    if (run.kind == identify::RunKind::bath) {
      EXPECT_LT(run.strain.rms, 0.002) << run.name;
      EXPECT_GT(run.strain.rms, 0.0004) << "the noise must be left";
    }
  }
  EXPECT_LT(fit.runs.front().power.rms, 0.02);
  // Only the calorimetry knows the heats; without its rate, how they belong together.
  const auto in_kelvins = [](const HeatParams<double>& heat) {
    return heat.latent_m2a_J_kg / heat.specific_heat_J_kgK;
  };
  EXPECT_NEAR(in_kelvins(fit.wire.heat) / in_kelvins(wire.heat), 1, 0.03);
  EXPECT_NEAR(fit.wire.kinetics.m2a.start_K[0], wire.kinetics.m2a.start_K[0], 1);
}

}  // namespace
}  // namespace smaservo::test
