#include "host-sim/identify/runs/run.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "host-sim/how_read.hpp"
#include "host-sim/identify/runs/run_checks.hpp"

namespace smaservo::identify {
namespace {

constexpr double measuring_W_m = 0.1;  ///< still air removes 0.04-0.07 W/mK from any thin wire
constexpr double rough_resistivity_ohm_m = 0.9e-6;
constexpr double min_current_share = 0.03;

double largest(const std::vector<double>& values) {
  double max = 0;
  for (const double value : values) {
    max = std::max(max, std::abs(value));
  }
  return max;
}

/// Whether the largest current of the run heats the wire.
bool is_heated(const Run& run, const Geometry<double>& geometry) {
  double max_W = 0;
  for (std::size_t i = 0; i < run.current_A.size(); ++i) {
    const double current_A = run.current_A[i];
    const double voltage_V = run.voltage_V.empty() ? current_A * rough_resistivity_ohm_m *
                                                         geometry.length_m / geometry.area_m2()
                                                   : run.voltage_V[i];
    max_W = std::max(max_W, std::abs(voltage_V * current_A));
  }
  return max_W > measuring_W_m * geometry.length_m;
}

RunKind kind_of(const Run& run, bool heated) {
  if (!run.power_W_kg.empty()) {
    if (run.temperature_K.empty()) {
      fail(run, "has power but no temperature; a calorimeter's run needs temperature_degC");
    }
    return RunKind::calorimetry;
  }
  if (run.current_A.empty() != run.voltage_V.empty() && (heated || run.temperature_K.empty())) {
    fail(run, fmt::format("has {0} but no {1}; record current and voltage of the wire, or its "
                          "temperature in a bath without heating it",
                          run.voltage_V.empty() ? "current" : "voltage",
                          run.voltage_V.empty() ? "voltage" : "current"));
  }
  if (heated || (run.temperature_K.empty() && !run.current_A.empty())) {
    return run.time_s.empty() ? RunKind::settled : RunKind::joule;
  }
  if (run.temperature_K.empty()) {
    fail(run,
         "does not tell the wire's temperature; record temperature_degC in a bath, or current_A "
         "and voltage_V (with time_s, unless each row is a settled state)");
  }
  return RunKind::bath;
}

/// V/I in rows with enough current to measure it, otherwise NaN.
std::vector<double> measured_resistance(const Run& run) {
  std::vector<double> all;
  if (run.current_A.empty() || run.voltage_V.empty()) {
    return all;
  }
  const double min_A = min_current_share * largest(run.current_A);
  for (std::size_t i = 0; i < run.current_A.size(); ++i) {
    const double current_A = run.current_A[i];
    all.push_back(current_A != 0 && std::abs(current_A) >= min_A
                      ? run.voltage_V[i] / current_A
                      : std::numeric_limits<double>::quiet_NaN());
  }
  return all;
}

std::vector<double> elongation(const std::vector<double>& displacement_m, double length_m) {
  std::vector<double> strain;
  if (displacement_m.empty()) {
    return strain;
  }
  const double longest_m = *std::ranges::min_element(displacement_m);
  for (const double at_m : displacement_m) {
    strain.push_back((longest_m - at_m) / length_m);
  }
  return strain;
}

std::vector<double> given_stress(const Run& run, const RunOptions& options, std::size_t rows) {
  if (run.kind == RunKind::calorimetry) {
    return std::vector<double>(rows, 0.0);
  }
  if (!options.stress_Pa && !options.load_N) {
    fail(run, "has neither load_N nor stress_MPa; give the load with --load-N or --stress-MPa");
  }
  return std::vector<double>(
      rows, options.stress_Pa ? *options.stress_Pa : *options.load_N / options.geometry.area_m2());
}

}  // namespace

std::string_view name_of(RunKind kind) {
  switch (kind) {
    case RunKind::bath:
      return "bath";
    case RunKind::joule:
      return "joule";
    case RunKind::settled:
      return "settled";
    case RunKind::calorimetry:
      return "calorimetry";
  }
  return "";
}

Run read_run(const std::string& path, const RunOptions& options) {
  hal::TraceOptions trace_options = options.trace;
  trace_options.resistance_and_power = true;
  hal::TraceReader trace(path, trace_options);
  say_how_read(path, trace);
  Run run{path == "-" ? "standard input" : path, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}};
  std::vector<double> load_N, displacement_m;
  struct ColumnValues {
    hal::Column column;
    std::vector<double>& values;
  };
  const ColumnValues columns[] = {{hal::Column::current, run.current_A},
                                  {hal::Column::voltage, run.voltage_V},
                                  {hal::Column::load, load_N},
                                  {hal::Column::stress, run.stress_Pa},
                                  {hal::Column::temperature, run.temperature_K},
                                  {hal::Column::ambient, run.ambient_K},
                                  {hal::Column::strain_ref, run.strain},
                                  {hal::Column::displacement, displacement_m},
                                  {hal::Column::resistance, run.resistance_ohm},
                                  {hal::Column::power, run.power_W_kg}};
  hal::TraceRow row{};
  while (trace.next(row)) {
    if (trace.timed()) {
      run.time_s.push_back(row[hal::Column::time]);
    }
    for (const ColumnValues& channel : columns) {
      if (trace.has(channel.column)) {
        channel.values.push_back(row[channel.column]);
      }
    }
  }
  say_what_was_skipped(path, trace);
  for (const std::string& complaint : trace.complaints()) {
    files::complain("host-sim", fmt::format("{}: skipped: {}", run.name, complaint));
  }
  if (trace.rows() == 0) {
    fail(run, "has no usable row");
  }
  run.kind = kind_of(run, is_heated(run, options.geometry));
  if (run.stress_Pa.empty()) {
    for (const double newton : load_N) {
      run.stress_Pa.push_back(newton / options.geometry.area_m2());
    }
  }
  if (run.stress_Pa.empty()) {
    run.stress_Pa = given_stress(run, options, static_cast<std::size_t>(trace.rows()));
  }
  if (run.strain.empty()) {
    run.strain = elongation(displacement_m, options.geometry.length_m);
  }
  if (run.resistance_ohm.empty()) {
    run.resistance_ohm = measured_resistance(run);
  }
  check_run(run, options.geometry);
  return run;
}

bool zero_known(const std::vector<double>& strain) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double x : strain) {
    low = x < low ? x : low;  // both comparisons are false for NaN
    high = high < x ? x : high;
  }
  return std::abs(low) > 1e-7 && std::abs(high) > 1e-7;
}

}  // namespace smaservo::identify
