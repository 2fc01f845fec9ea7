#pragma once
// Runs a closed loop from beginning to end: its trace and its results.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "firmware/command.hpp"
#include "host-sim/report/series.hpp"
#include "host-sim/report/step_figures.hpp"

namespace smaservo::simulate {

/// One point of a closed loop's plots, in the units of their axes. NaN leaves a gap.
struct LoopPoint {
  double time_s;
  double setpoint_percent, reference_percent, strain_percent, estimate_percent;
  double estimate_error_percent, control_error_percent;  ///< in per cent of the nominal stroke
  double current_A, power_W;
  double wire_degC, hot_spot_degC, hottest_degC;
  double stress_MPa, resistance_ohm;
  double other_setpoint, other_measured;  ///< for modes that do not control the length, in SI
};

using LoopSeries =
    report::SeriesOf<LoopPoint, &LoopPoint::setpoint_percent, &LoopPoint::reference_percent,
                     &LoopPoint::strain_percent, &LoopPoint::estimate_percent,
                     &LoopPoint::estimate_error_percent, &LoopPoint::control_error_percent,
                     &LoopPoint::current_A, &LoopPoint::power_W, &LoopPoint::wire_degC,
                     &LoopPoint::hot_spot_degC, &LoopPoint::hottest_degC, &LoopPoint::stress_MPa,
                     &LoopPoint::resistance_ohm, &LoopPoint::other_setpoint,
                     &LoopPoint::other_measured>;

/// Spans of time, each from its beginning to its end.
using Spans = std::vector<std::pair<double, double>>;

/// The part of a run that a report shows.
struct LoopRecord {
  LoopSeries series;
  std::map<LimitReason, Spans> limits;
  std::map<Fault, Spans> latched, warnings;
  std::map<DeviceState, Spans> states;
};

struct LoopRunResult {
  std::uint64_t steps = 0;
  double duration_s = 0, elapsed_s = 0;
  std::vector<report::StepFigures> strain_steps;
  double max_hottest_K = 0;
  double max_hottest_s = 0;
  double max_current_A = 0;
  double max_estimate_error = 0;  ///< greatest error of the strain after the first second
  /// Faults with their times, in the order in which they were latched.
  std::vector<std::pair<Fault, double>> faults;
  std::optional<LoopRecord> record;
};

struct LoopRunOptions {
  std::string out;      ///< CSV file, "-" for standard output; empty: none
  bool record = false;  ///< collects the data for a report
};

/// A set-point of this mode as a strain; NaN in modes that do not control the length.
double wanted_strain(const Settings<double>& settings, Mode mode, double value);

/// Throws UserError.
LoopRunResult run_closed_loop(const bench::ClosedLoopScenario& scenario,
                              const LoopRunOptions& options);

/// A sentence for each step that ended outside of +-2 % of the stroke around its set-point: the
/// fault that ended it, or the limits that held it and the settings that they come from.
std::vector<std::string> unreached(const bench::ClosedLoopScenario& scenario,
                                   const LoopRunResult& result);

/// The numbers for a terminal.
std::string summary(const bench::ClosedLoopScenario& scenario, const LoopRunResult& result);

}  // namespace smaservo::simulate
