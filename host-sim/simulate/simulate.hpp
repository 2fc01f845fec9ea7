#pragma once
// Runs a scenario on a simulated wire, measured by noisy and quantised sensors.

#include <functional>

#include "firmware/bench/scenario/scenario.hpp"
#include "hal/recording/trace_file.hpp"

namespace smaservo::simulate {

/// The readings, and the true strain.
struct SimulatedRow {
  double time_s, current_A, voltage_V, load_N, strain;
};
using RowSink = std::function<void(const SimulatedRow&)>;

/// Writes the trace; the same scenario gives the same trace.
void simulate(const bench::Scenario& scenario, hal::TraceFile& trace);

/// Gives the same rows before they are rounded to the digits of a file. The scenario's run must be
/// a JouleScenario; throws std::bad_variant_access for a bath.
void simulate_rows(const bench::Scenario& scenario, const RowSink& sink);

/// The readings of a bath at each of its steps; the temperature is noisy.
struct SimulatedBathRow {
  double temperature_K, stress_Pa, strain;
};
/// Like simulate_rows(), for a BathScenario.
void simulate_bath_rows(const bench::Scenario& scenario,
                        const std::function<void(const SimulatedBathRow&)>& sink);

}  // namespace smaservo::simulate
