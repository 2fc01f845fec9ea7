#pragma once
// Which currents to run on a bench, so that identify can determine a wire's parameters: profiles
// chosen by the deviations that a fit to such runs would leave. host-sim/plan/README.md has the
// method.

#include <cstddef>
#include <functional>
#include <vector>

#include "host-sim/identify/fit/parameters.hpp"

namespace smaservo::plan {

/// A plan keeps the wire this much below wire.limits.temperature.
inline constexpr double plan_margin_K = 10;
/// And its current below this multiple of limits.current. That is a rating for hours, by which some
/// wires do not even contract under load; what harms a wire is the temperature.
inline constexpr double plan_current = 1.5;

struct PlanOptions {
  std::vector<double> stresses_Pa;  ///< one run under each; none: the best three of a list
  double duration_s = 60;           ///< of each run, 10 to 600
  int threads = 1;                  ///< makes no difference to the plan
  /// Called now and then with the number of profiles that have been tried, and that will be.
  std::function<void(std::size_t done, std::size_t total)> progress = [](std::size_t, std::size_t) {
  };
};

/// One run; all vectors have an element for each step. The wire is at rest at 25 °C before.
struct PlannedRun {
  double stress_Pa;
  std::vector<double> current_A;  ///< during the step
  // The state that the wire's own model predicts for the end of the step:
  std::vector<double> temperature_K, strain;
};

/// Deviations that a fit would leave, divided by those of the prior: 1 where the runs tell nothing.
struct ExpectedParameter {
  identify::FitParameter parameter;
  double triangle, plan;
};

struct Plan {
  double step_s;
  std::vector<PlannedRun> runs;  ///< by rising stress, or in the order of the options
  /// One slow rise and fall of the current to each run's peak, with which the plan is compared.
  std::vector<PlannedRun> triangles;
  std::vector<ExpectedParameter> parameters;
};

/// For one member of ExpectedParameter: how many parameters have a deviation below half of the
/// prior's, and the mean logarithm, by which a plan is chosen.
std::size_t determined(const Plan& plan, double ExpectedParameter::* deviation);
double mean_logarithm(const Plan& plan, double ExpectedParameter::* deviation);

/// Takes some ten seconds for a minute of 3 runs. Throws UserError for a duration or a stress out
/// of range; the greatest stress is wire.limits.load's.
Plan plan_runs(const Wire<double>& wire, const PlanOptions& options);

}  // namespace smaservo::plan
