// A wire whose R-phase becomes austenite 3 K above where it came from austenite, 15 K below where
// martensite does. A fit that looks for R2A near M2A ends beside the truth.

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "host-sim/identify/fit/fit.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/wire/wire_plant.hpp"

namespace smaservo::test {
namespace {

/// A cycle and some steps of the current, 24 s at 50 rows/s.
identify::Run joule_run(const Wire<double>& wire, double load_Pa, std::mt19937_64& random) {
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

/// Of the greatest resistance error of all runs, at the measured strain, RMS.
double resistance_error(const identify::FitResult& fit) {
  double greatest = 0;
  for (const identify::FittedRun& run : fit.runs) {
    greatest = std::max(greatest, run.given_strain.rms);
  }
  return greatest;
}

TEST(IdentifyRPhase, ThatReturnsCloseToWhereItCameIsFound) {
  const Wire<double> type = files::load_wire("smartflex-76um").wire;
  Wire<double> wire = type;
  wire.kinetics.separate_r2a = true;
  wire.kinetics.r2a = identify::r2a_above(second_surface(type.kinetics.a2m_a2r), 3);
  for (double* temperature_K : {&wire.kinetics.m2a.start_K[0], &wire.kinetics.m2a.finish_K[0]}) {
    *temperature_K += 2;
  }
  std::mt19937_64 random(1);
  std::vector<identify::Run> runs;
  for (const double stress_MPa : {10.0, 100.0}) {
    runs.push_back(joule_run(wire, 1e6 * stress_MPa, random));
  }
  const identify::FitResult found = identify::fit_wire(type, runs, {});
  EXPECT_TRUE(found.variant.r2a_near_a2r);
  const auto middle_K = [](const Surface<double>& r2a) {
    const Isobar<double> at = isobar(r2a, 10e6);
    return at.start_K + at.shape.turning / at.per_K;
  };
  EXPECT_NEAR(middle_K(found.wire.kinetics.r2a), middle_K(wire.kinetics.r2a), 1.5);
  const identify::FitResult as_m2a = identify::fit_wire(type, runs, {.variants = false});
  EXPECT_LT(resistance_error(found), 0.5 * resistance_error(as_m2a));
}

}  // namespace
}  // namespace smaservo::test
