#pragma once
// A wire's parameters from measured runs: nonlinear least squares through the model itself.
// host-sim/identify/README.md has the method.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/identify/fit/cost/prediction.hpp"
#include "host-sim/identify/fit/parameters.hpp"
#include "host-sim/identify/runs/run.hpp"

namespace smaservo::identify {

/// Where a fit is; it goes on as long as the answer is true.
struct FitProgress {
  std::string stage;
  int iteration;
  double cost;
};

struct FitOptions {
  int threads = 1;
  bool variants = true;  ///< also try other structures of the model: separate surfaces, mixture
  bool circuit = false;  ///< also fit the resistance of the leads and the gain of the load cell
  int max_iterations = 40;
  std::function<bool(const FitProgress&)> proceed = [](const FitProgress&) { return true; };
};

struct FittedParameter {
  FitParameter parameter;
  double value;        ///< SI
  double sd;           ///< of value; relative for a factor, in logits for a share
  double uncertainty;  ///< sd by that of the prior: 1 where the data say nothing

  /// Otherwise it keeps its prior, or little else.
  bool determined() const { return uncertainty < 0.5; }
};

struct Correlation {
  std::string first, second;
  double value;
};

/// Differences between prediction and measurement, in the run's own order.
struct FitQuality {
  double rms = 0, p95 = 0, maximum = 0;
  std::size_t count = 0;
};

struct FittedRun {
  std::string name;
  RunKind kind;
  FitQuality strain;        ///< in shares of the nominal stroke
  FitQuality resistance;    ///< relative
  FitQuality given_strain;  ///< of the resistance where the model has the measured strain
  FitQuality power;         ///< calorimetry, in shares of the greatest heat flow
  Circumstances<double> circumstances;
  // Of every comparison, for plots and tables; NaN where there is none.
  std::vector<double> temperature_K;  ///< as far as it is measured or follows from the fit
  std::vector<double> strain_measured, strain_model;
  std::vector<double> resistance_measured, resistance_model, resistance_given_strain;
  std::vector<double> ambiguity;  ///< Predicted's
};

struct FitResult {
  Wire<double> wire;
  FitVariant variant;
  std::vector<FittedParameter> parameters;
  std::vector<Correlation> correlations;  ///< of what is determined, the worst first
  std::vector<FittedRun> runs;
  CircuitGuess<double> circuit{};
  bool circuit_fitted = false;
  bool interrupted = false;
  int iterations = 0;
};

/// Throws UserError when the runs can not determine anything.
FitResult fit_wire(const Wire<double>& from, const std::vector<Run>& runs,
                   const FitOptions& options);

/// Steps of a thinned run in time: of the result, and as long as the way there is long.
inline constexpr double fine_step_s = 8e-3;
inline constexpr double coarse_step_s = 24e-3;

/// A run thinned for the fit, to steps of about so long and at most 1500 comparisons.
FitRun thin_run(const Run& run, double step_s = fine_step_s);

}  // namespace smaservo::identify
