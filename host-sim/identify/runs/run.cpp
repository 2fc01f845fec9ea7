#include "host-sim/identify/runs/run.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include "host-sim/checks/findings.hpp"
#include "host-sim/checks/statistics.hpp"
#include "host-sim/how_read.hpp"
#include "model/files/error.hpp"

namespace smaservo::identify {
namespace {

constexpr double measuring_W_m = 0.1;  ///< still air removes 0.04-0.07 W/mK from any thin wire
constexpr double rough_resistivity_ohm_m = 0.9e-6;
constexpr std::size_t min_rows = 20;
constexpr double min_strain = 0.003;
constexpr double min_resistance_change = 0.02;
constexpr double min_temperature_span_K = 10;

[[noreturn]] void fail(const Run& run, const std::string& what) {
  throw files::UserError(fmt::format("{}: {}", run.name, what));
}

/// Whether the largest current of the run heats the wire.
bool is_heated(const Run& run, const Geometry<double>& geometry) {
  double max_W = run.heating_W.empty() ? 0 : checks::range_of(run.heating_W).high;
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
  const bool powered = !run.current_A.empty() || !run.heating_W.empty();
  if (heated || (run.temperature_K.empty() && powered)) {
    return run.time_s.empty() ? RunKind::settled : RunKind::joule;
  }
  if (run.temperature_K.empty()) {
    fail(run,
         "does not tell the wire's temperature; record temperature_degC in a bath, or current_A "
         "and voltage_V (with time_s, unless each row is a settled state)");
  }
  return RunKind::bath;
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

void check_content(const Run& run, bool strain_optional) {
  if (run.stress_Pa.size() < min_rows) {
    fail(run, fmt::format("has {} rows, at least {} are needed; record a full heating and cooling",
                          run.stress_Pa.size(), min_rows));
  }
  if (run.kind == RunKind::calorimetry) {
    const checks::Range temperature_K = checks::range_of(run.temperature_K);
    if (temperature_K.high - temperature_K.low < min_temperature_span_K) {
      fail(run, fmt::format("the temperature spans {:.1f} K; heat and cool the sample through both "
                            "transformations",
                            temperature_K.high - temperature_K.low));
    }
    return;
  }
  const bool resistance_is_enough =
      run.kind == RunKind::bath || (strain_optional && run.kind == RunKind::joule);
  if (run.strain.empty() && (!resistance_is_enough || run.resistance_ohm.empty())) {
    fail(run, fmt::format("has nothing to fit a {} run to; record strain_ref or displacement_mm{}",
                          name_of(run.kind),
                          run.kind == RunKind::bath
                              ? ", or resistance_ohm, or (of a calorimeter) power_W_per_g"
                              : ""));
  }
  const checks::Range strain = checks::range_of(run.strain);
  const checks::Range ohm = checks::range_of(run.resistance_ohm);
  const double change = ohm.middle > 0 ? (ohm.high - ohm.low) / ohm.middle : 0;
  if (strain.high - strain.low < min_strain && change < min_resistance_change) {
    fail(run,
         fmt::format("the wire does not move: strain spans {:.2f} %, resistance {:.1f} %; heat "
                     "and cool it through both transformations",
                     100 * (strain.high - strain.low), 100 * change));
  }
}

/// A run with an imposed strain needs what acts on the wire in every row, and what answers.
void check_imposed(const Run& run) {
  for (const auto& [name, values] : {std::pair{"strain_ref or displacement_mm", &run.strain},
                                     std::pair{"load_N or stress_MPa", &run.stress_Pa}}) {
    if (values->empty()) {
      fail(run, fmt::format("has no {}; with --imposed-strain the load is computed from strain and "
                            "power, so both must be recorded",
                            name));
    }
  }
}

}  // namespace

Run run_of(checks::Record record, const RunOptions& options) {
  Run run = std::move(record);
  if (run.lines.empty()) {
    fail(run, "has no usable row");
  }
  run.kind = kind_of(run, is_heated(run, options.geometry));
  if (options.imposed_strain && run.kind == RunKind::joule) {
    run.kind = RunKind::imposed;
    check_imposed(run);
  }
  if (run.stress_Pa.empty()) {
    run.stress_Pa = given_stress(run, options, run.lines.size());
  }
  check_content(run, options.strain_optional);
  return run;
}

Run read_run(const std::string& path, const RunOptions& options) {
  hal::TraceOptions trace_options = options.trace;
  trace_options.resistance_and_power = true;
  hal::TraceReader trace(path, trace_options);
  say_how_read(path, trace);
  checks::Recorder recorder(trace);
  hal::TraceRow row{};
  while (trace.next(row)) {
    recorder.add(row);
  }
  Run run = recorder.finish(path == "-" ? "standard input" : path, options.geometry);
  say_what_was_skipped(path, trace);
  for (const std::string& complaint : trace.complaints()) {
    files::complain("host-sim", fmt::format("{}: skipped: {}", run.name, complaint));
  }
  run = run_of(std::move(run), options);
  checks::refuse_mistakes(run, {options.geometry}, options.allowed);
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
