#include "host-sim/simulate/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <memory>
#include <random>

#include "hal/recording/trace_file.hpp"
#include "hal/sim/simulated_bench.hpp"
#include "model/units.hpp"
#include "model/wire/plant.hpp"

namespace smaservo::simulate {
namespace {

constexpr double step_s = 1e-3;
constexpr double gust_s = 0.1;  ///< time constant with which the air comes to move

std::unique_ptr<hal::SimulatedWire> make_wire(const bench::Scenario& scenario,
                                              std::mt19937_64& random) {
  return hal::make_simulated_wire(scenario.family, scenario.wire.wire, scenario.structure,
                                  scenario.scatter_K, random);
}

void run_joule(const bench::Scenario& scenario, const bench::JouleScenario& joule,
               const RowSink& sink) {
  const Wire<double>& wire = scenario.wire.wire;
  std::mt19937_64 random(scenario.seed + 1);
  std::normal_distribution<double> normal;
  const auto plant = make_wire(scenario, random);
  hal::LoadModel load(joule.load);
  plant->rest(joule.ambient_K, load.stress_Pa());
  // Levels are computed by the lumped heat balance, so the plant may end at another temperature.
  const auto body = thermal_body(wire.geometry, wire.heat);
  const double hottest_K = [&] {
    const Isobar<double> m2a = isobar(wire.kinetics.m2a, load.stress_Pa());
    return m2a.start_K + 1 / m2a.per_K + joule.overheat_K;
  }();
  const long every = std::lround(1 / (joule.rate_Hz * step_s));
  long tick = 0;
  double draught = 1;
  for (const bench::DriveStep& step : joule.drive) {
    const double level_W = step.level * body.loss_W(hottest_K - room_K);
    const long begin = tick;
    for (const long stop = tick + std::lround(step.seconds / step_s); tick < stop; ++tick) {
      const double time_s = static_cast<double>(tick) * step_s;
      const double strain = plant->strain();
      const double phase = static_cast<double>(tick - begin) * step_s * step.ripple_Hz;
      const double power_W = level_W * (1 + step.ripple * std::sin(2 * std::numbers::pi * phase));
      load.advance(time_s, step_s, strain, random);
      const double ohm = plant->resistance_ohm();
      const double current_A = std::max(std::sqrt(power_W / ohm), joule.min_current_A);
      const hal::Readings read =
          hal::read_sensors(joule.sensors, current_A, ohm,
                            load.stress_Pa() * wire.geometry.area_m2(), normal, random);
      if (tick % every == 0 && time_s >= joule.record_from_s) {
        sink({time_s - joule.record_from_s, read.current_A, read.voltage_V, read.load_N, strain});
      }
      draught += step_s / gust_s * (step.draught - draught);
      plant->advance(current_A, {load.stress_Pa(), joule.ambient_K, joule.draught * draught},
                     step_s);
    }
  }
}

void run_bath(const bench::Scenario& scenario, const bench::BathScenario& bath,
              const std::function<void(const SimulatedBathRow&)>& sink) {
  std::mt19937_64 random(scenario.seed + 1);
  std::normal_distribution<double> normal;
  const auto plant = make_wire(scenario, random);
  double T = bath.turning_K.front();
  plant->rest(T, bath.stress_Pa);
  const auto record = [&] {
    plant->soak(T, bath.stress_Pa);
    sink({T + bath.temperature_noise_K * normal(random), bath.stress_Pa, plant->strain()});
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

void simulate(const bench::Scenario& scenario, hal::TraceFile& trace) {
  if (std::holds_alternative<bench::BathScenario>(scenario.run)) {
    trace.write("temperature_degC,stress_MPa,strain_ref\n");
    simulate_bath_rows(scenario, [&](const SimulatedBathRow& row) {
      trace.write(fmt::format("{:.3f},{:.3f},{:.6f}\n", row.temperature_K - zero_degC_K,
                              row.stress_Pa * 1e-6, row.strain));
    });
    return;
  }
  trace.write("time_s,current_A,voltage_V,load_N,strain_ref\n");
  simulate_rows(scenario, [&](const SimulatedRow& row) {
    trace.write(fmt::format("{:.3f},{:.6f},{:.5f},{:.4f},{:.6f}\n", row.time_s, row.current_A,
                            row.voltage_V, row.load_N, row.strain));
  });
}

void simulate_rows(const bench::Scenario& scenario, const RowSink& sink) {
  run_joule(scenario, std::get<bench::JouleScenario>(scenario.run), sink);
}

void simulate_bath_rows(const bench::Scenario& scenario,
                        const std::function<void(const SimulatedBathRow&)>& sink) {
  run_bath(scenario, std::get<bench::BathScenario>(scenario.run), sink);
}

}  // namespace smaservo::simulate
