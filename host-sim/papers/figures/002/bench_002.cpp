#include "host-sim/papers/figures/002/bench_002.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <utility>

#include "host-sim/simulate/simulate.hpp"

namespace smaservo::figures::bench_002 {
namespace {

constexpr double MPa = 1e6;

using Steps = std::vector<bench::DriveStep>;

void full_cycles(Steps& drive, int count) {
  for (int i = 0; i < count; ++i) {
    drive.push_back({1, 7});
    drive.push_back({0, 9});
  }
}

/// The `overheat_K` with which level 1 ends 15 K above the finish at the highest stress. Levels are
/// computed for the first stress.
double overheat_K(const hal::Load& load) {
  const auto* spring = std::get_if<hal::SpringLoad>(&load);
  if (spring == nullptr) {
    return 15;
  }
  const Surface<double> m2a = wire().wire.kinetics.m2a;
  const auto finish_K = [&](double stress_Pa) {
    const Isobar<double> at = isobar(m2a, stress_Pa);
    return at.start_K + 1 / at.per_K;
  };
  return 15 + finish_K(spring->high_Pa) - finish_K(spring->low_Pa);
}

bench::Scenario scenario(hal::Family family, const hal::Load& load, Steps drive) {
  bench::JouleScenario joule{.ambient_K = room_K,
                             .draught = 1,
                             .overheat_K = overheat_K(load),
                             .min_current_A = min_current_A,
                             .rate_Hz = 200,
                             .record_from_s = 0,
                             .drive = std::move(drive),
                             .load = load,
                             .sensors = sensors()};
  return {"bench of paper 002", wire(), 2, 0.5, family, {}, std::move(joule)};
}

identify::Run measured(std::string name, const bench::Scenario& scenario) {
  identify::Run run{};
  run.name = std::move(name);
  run.kind = identify::RunKind::joule;
  simulate::simulate_rows(scenario, [&](const simulate::SimulatedRow& row) {
    run.time_s.push_back(row.time_s);
    run.current_A.push_back(row.current_A);
    run.voltage_V.push_back(row.voltage_V);
    run.stress_Pa.push_back(stress_Pa(row.load_N));
    run.strain.push_back(row.strain);
    run.resistance_ohm.push_back(row.voltage_V / row.current_A);
  });
  return run;
}

}  // namespace

files::WireDescription wire() {
  return files::load_wire("flexinol-lt-0.15mm");
}

double stress_Pa(double load_N) {
  static const Wire<double> wire_of_all = wire().wire;
  return wire_of_all.stress_Pa(load_N);
}

std::vector<double> calibration_stresses_Pa() {
  std::vector<double> all;
  for (const double stress_MPa : {15.0, 35.0, 55.0, 75.0, 95.0, 115.0, 135.0, 155.0, 175.0}) {
    all.push_back(stress_MPa * MPa);
  }
  return all;
}

identify::Run calibration_run(hal::Family family, double stress_Pa) {
  Steps drive{{0, 1}};
  full_cycles(drive, 2);
  for (const double level : {0.62, 0.68, 0.74, 0.8}) {
    drive.push_back({level, 5});
    drive.push_back({0, 7});
  }
  for (const double level : {0.3, 0.36, 0.42, 0.48}) {
    drive.push_back({1, 5});
    drive.push_back({level, 5});
  }
  drive.push_back({1, 5});
  drive.push_back({0, 7});
  return measured(fmt::format("{:.0f} MPa", stress_Pa / MPa),
                  scenario(family, hal::ConstantLoad{stress_Pa}, std::move(drive)));
}

fits::StrainResistanceFit calibrate(hal::Family family) {
  std::vector<identify::Run> runs;
  for (const double stress_Pa : calibration_stresses_Pa()) {
    runs.push_back(calibration_run(family, stress_Pa));
  }
  return fits::identify_strain_resistance(runs);
}

hal::SpringLoad spring() {
  return {20 * MPa, 170 * MPa, 0.03, 0.05};
}

hal::Sensors sensors() {
  return {.bits = 16,
          .current_full_scale_A = 1,
          .voltage_full_scale_V = 5,
          .load_full_scale_N = 5,
          .current_noise_A = 3e-6,
          .voltage_noise_V = 0.1e-3,
          .load_noise_N = 2e-3,
          .load_gain = 1,
          .resistance_gain = 1};
}

identify::Run validation_run(hal::Family family, const hal::Load& load) {
  Steps drive{{0, 1}};
  full_cycles(drive, 2);
  for (const double level : {0.6, 0.65, 0.7, 0.75}) {
    drive.push_back({level, 7});
    drive.push_back({0, 7});
  }
  for (const double level : {0.33, 0.39, 0.45, 0.5}) {
    drive.push_back({1, 5});
    drive.push_back({level, 7});
  }
  drive.push_back({0, 7});
  return measured("validation", scenario(family, load, std::move(drive)));
}

double mean_error_percent(const std::vector<double>& strain, const identify::Run& run) {
  double sum = 0;
  for (std::size_t i = 0; i < strain.size(); ++i) {
    sum += std::abs(strain[i] - run.strain[i]);
  }
  return 100 * sum / (0.04 * static_cast<double>(strain.size()));
}

identify::Run with_constant_stress(identify::Run run) {
  std::ranges::fill(run.stress_Pa, *std::ranges::max_element(run.stress_Pa));
  return run;
}

}  // namespace smaservo::figures::bench_002
