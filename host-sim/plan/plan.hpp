#pragma once
// Plans currents for runs on a bench from which `identify` can determine a wire's parameters:
// profiles chosen by the deviations that a fit to such runs would leave. host-sim/plan/README.md
// has the method.

#include <cstddef>
#include <functional>
#include <vector>

#include "host-sim/identify/fit/parameters.hpp"

namespace smaservo::plan {

/// A plan keeps the wire this much below wire.limits.temperature.
inline constexpr double plan_margin_K = 10;
/// A plan keeps the current below this multiple of limits.current. That limit is a rating for
/// hours, at which some wires do not even contract under load; what damages a wire is the
/// temperature.
inline constexpr double plan_current = 1.5;

struct PlanOptions {
  std::vector<double> stresses_Pa;  ///< one run at each; none: the best three of a list
  double duration_s = 60;           ///< duration of each run, 10 to 600
  int threads = 1;                  ///< does not affect the plan
  /// Called from time to time with the number of profiles tried so far, and their total number.
  std::function<void(std::size_t done, std::size_t total)> progress = [](std::size_t, std::size_t) {
  };
};

/// One run; all vectors have an element for each step. The wire is at rest at 25 °C before the run.
struct PlannedRun {
  double stress_Pa;
  std::vector<double> current_A;  ///< current during the step
  // The predictions of the wire's own model for the end of the step:
  std::vector<double> temperature_K, strain;
};

/// Deviations that a fit would leave, relative to those of the prior: 1 if the runs give no
/// information.
struct ExpectedParameter {
  identify::FitParameter parameter;
  double triangle, plan;
};

struct Plan {
  double step_s;
  std::vector<PlannedRun> runs;  ///< sorted by stress, or in the order of the options
  /// One slow rise and fall of the current to the peak of each run, for comparison with the plan.
  std::vector<PlannedRun> triangles;
  std::vector<ExpectedParameter> parameters;
};

/// For one member of ExpectedParameter: the number of parameters whose deviation is below half of
/// the prior's, and the mean logarithm, by which a plan is chosen.
std::size_t determined(const Plan& plan, double ExpectedParameter::* deviation);
double mean_logarithm(const Plan& plan, double ExpectedParameter::* deviation);

/// Takes some ten seconds for a minute of 3 runs. Throws UserError for a duration or a stress out
/// of range; the greatest stress is wire.limits.load's.
Plan plan_runs(const Wire<double>& wire, const PlanOptions& options);

}  // namespace smaservo::plan
