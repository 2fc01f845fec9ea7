// Calorimetry and baths in one fit.

#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "host-sim/identify/fit/fit.hpp"
#include "model/files/wire/wire_file.hpp"
#include "tests/host-sim/identify/simulated_runs.hpp"

namespace smaservo::test {
namespace {

/// The preset with another M2A, other heats, which only calorimetry sees, and another strain of
/// martensite, which only baths see.
Wire<double> truth() {
  Wire<double> wire = files::load_wire("smartflex-76um").wire;
  wire.kinetics.m2a.start_K[0] += 4;
  wire.kinetics.m2a.finish_K[0] += 4;
  wire.heat.latent_m2a_J_kg *= 1.2;
  wire.heat.specific_heat_J_kgK *= 1.08;
  wire.material.martensite.strain += 0.004;
  return wire;
}

std::vector<identify::Run> runs(const Wire<double>& wire) {
  std::mt19937_64 random(5);
  std::vector<identify::Run> all{calorimetry_run(wire, random)};
  for (const double stress_Pa : {20e6, 100e6, 250e6}) {
    all.push_back(bath_run(wire, stress_Pa, random));
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
  // Only the calorimetry determines the heats, and only their ratio, as its heating rate is not
  // known.
  const auto in_kelvins = [](const HeatParams<double>& heat) {
    return heat.latent_m2a_J_kg / heat.specific_heat_J_kgK;
  };
  EXPECT_NEAR(in_kelvins(fit.wire.heat) / in_kelvins(wire.heat), 1, 0.03);
  EXPECT_NEAR(fit.wire.kinetics.m2a.start_K[0], wire.kinetics.m2a.start_K[0], 1);
}

/// With time the rate is known, and so each of the heats; scans may have different rates, and holds
/// between them.
TEST(Calorimetry, WithTimeTellsEachHeat) {
  const Wire<double> wire = truth();
  std::mt19937_64 random(6);
  identify::Run run = calorimetry_run(wire, random);
  constexpr double zero_W_kg = -4000;
  double now_s = 0;
  for (std::size_t i = 0; i < run.temperature_K.size(); ++i) {
    const double change_K = i == 0 ? 0.5 : run.temperature_K[i] - run.temperature_K[i - 1];
    const double times = change_K < 0 ? 0.5 : 1;  // cooled at half of the rate
    now_s +=
        std::abs(change_K) / (times * rate_K_s) + (i == run.temperature_K.size() / 2 ? 300 : 0);
    run.time_s.push_back(now_s);
    run.power_W_kg[i] = zero_W_kg + times * run.power_W_kg[i];
  }
  identify::FitOptions options;
  options.variants = false;
  const identify::FitResult fit =
      identify::fit_wire(files::load_wire("smartflex-76um").wire, {run}, options);
  EXPECT_LT(fit.runs.front().power.rms, 0.02);
  EXPECT_NEAR(fit.wire.heat.specific_heat_J_kgK / wire.heat.specific_heat_J_kgK, 1, 0.03);
  EXPECT_NEAR(fit.wire.heat.latent_m2a_J_kg / wire.heat.latent_m2a_J_kg, 1, 0.05);
}

}  // namespace
}  // namespace smaservo::test
