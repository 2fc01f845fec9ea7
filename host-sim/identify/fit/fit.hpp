#pragma once
// Determines a wire's parameters from measured runs: nonlinear least squares through the model
// itself. host-sim/identify/README.md has the method.

#include <array>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/identify/fit/cost/prediction.hpp"
#include "host-sim/identify/fit/parameters.hpp"
#include "host-sim/identify/runs/run.hpp"

namespace smaservo::identify {

/// The progress of a fit, for FitOptions::proceed. The fit ends if proceed returns false.
struct FitProgress {
  std::string stage;
  int iteration;
  double cost;
  /// Of the whole fit, 0 to 1, as fits usually go: how many iterations a stage needs is known only
  /// when it has ended.
  double share;
};

/// That share, at an iteration of a stage. A later stage never has less.
double usual_share(std::string_view stage, int iteration);

/// What a fit takes for given about the ends of the curves and the order of the inner loops.
enum class Structure : unsigned char {
  automatic,  ///< one of the others, by the observer's errors in runs that are left out
  paper_000,  ///< neither is fitted, except where `from` has others than paper 000
  ordered     ///< both are fitted (model/README.md)
};
/// Their names, by value.
inline constexpr std::array<std::string_view, 3> structure_names{"auto", "paper-000", "ordered"};
/// The structure with this name, which must be one of them.
inline Structure structure_named(std::string_view name) {
  return name == structure_names[0]   ? Structure::automatic
         : name == structure_names[1] ? Structure::paper_000
                                      : Structure::ordered;
}
inline std::string_view structure_name(Structure structure) {
  return structure_names.at(static_cast<std::size_t>(structure));
}

struct FitOptions {
  Structure structure = Structure::automatic;
  int threads = 1;
  bool variants = true;  ///< also try other structures of the model: separate surfaces, mixture
  bool circuit = false;  ///< also fit the resistance of the leads and the gain of the load cell
  int max_iterations = 40;
  std::function<bool(const FitProgress&)> proceed = [](const FitProgress&) { return true; };
};

struct FittedParameter {
  FitParameter parameter;
  double value;  ///< SI; exactly the prior if it is not determined
  double sd;     ///< standard deviation of value; relative for a factor, in logits for a share
  double uncertainty;  ///< sd divided by that of the prior: 1 if the data give no information
  /// Whether the runs have at least halved the prior's standard deviation, or moved the value by
  /// more than two times `sd`, or the fit is clearly worse without it. `sd` includes the
  /// uncertainty of the parameters that are not determined.
  bool determined;
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
  FitQuality strain;      ///< as a share of the nominal stroke
  FitQuality resistance;  ///< relative
  /// Error of the resistance after the model's strain is corrected to the measured one.
  FitQuality given_strain;
  FitQuality power;      ///< calorimetry, as a share of the greatest heat flow
  FitQuality stress_Pa;  ///< imposed strain
  Circumstances<double> circumstances;
  // One element for every comparison, for plots and tables; NaN: not compared.
  std::vector<double> temperature_K;  ///< measured, or otherwise that of the fit
  std::vector<double> strain_measured, strain_model;
  std::vector<double> resistance_measured, resistance_model, resistance_given_strain;
  std::vector<double> ambiguity;                            ///< see Predicted
  std::vector<double> stress_measured_Pa, stress_model_Pa;  ///< imposed strain
};

/// How the observer errs with a structure: the mean error of its strain in each of the judged runs,
/// as a share of the nominal stroke.
struct JudgedStructure {
  Structure structure;
  std::vector<double> seen;  ///< with the wire that was fitted to all runs
  /// With a wire that was fitted without the run; empty if `seen` was not clearly less than that of
  /// the structure before, which then stays.
  std::vector<double> unseen;
};

/// The mean of these errors; NaN if there are none.
double mean_error(const std::vector<double>& errors);

/// With fewer runs than these a half of them would not tell how the wire depends on stress.
inline constexpr std::size_t least_judged_runs = 4;

/// How the structure was chosen.
struct Judgement {
  /// The judged runs by rising stress; empty if there are fewer than least_judged_runs in which an
  /// observer can be judged: heated by current, with strain and resistance.
  std::vector<std::size_t> runs;
  std::vector<JudgedStructure> structures;

  /// The one with which the fit went on. At least one must have been judged.
  Structure chosen() const;
};

struct FitResult {
  Wire<double> wire;
  FitVariant variant;
  std::vector<FittedParameter> parameters;
  /// Correlations between determined parameters, the strongest first.
  std::vector<Correlation> correlations;
  std::vector<FittedRun> runs;
  Structure structure_asked;  ///< FitOptions::structure
  Judgement judgement;
  /// RMS error of the strain that the fit leaves. The wire's accuracy is greater where the observer
  /// would otherwise report too small a deviation in runs that the fit has not seen.
  double strain_sd = 0;
  /// Share of the observer's errors in the judged runs, left out, that are within twice the
  /// deviation it reports with this accuracy; NaN if none was judged.
  double share_within_2_sd = std::numeric_limits<double>::quiet_NaN();
  /// Before the fit, the transitions of `from` were moved by this much to where the runs show them;
  /// 0: they were within reach (runs/offset.hpp).
  double moved_K = 0;
  CircuitGuess<double> circuit{};
  bool circuit_fitted = false;
  bool interrupted = false;
  bool converged = true;  ///< the last restart of the solver reduced the cost by less than 3 %
  int iterations = 0;
};

/// A parameter that the runs do not determine keeps the value of `from` to the last bit, except
/// that all transitions are moved where the runs show them beyond the reach of the fit. No
/// transition temperature falls with stress, at any stress up to the wire's limit. Throws UserError
/// if the runs cannot determine anything, or if a transition of `from` falls with stress.
FitResult fit_wire(const Wire<double>& from, const std::vector<Run>& runs,
                   const FitOptions& options);

/// Share of a run that is held out whose rows tell what belongs to it alone.
inline constexpr double held_out_known_share = 1.0 / 3;
/// How the fitted wire predicts runs that the fit has not seen. The first rows of each one tell its
/// zeros, air, heat loss and gain; only those behind them are judged. The air and the loss have the
/// priors of a fit.
std::vector<FittedRun> held_out(const FitResult& fit, const std::vector<Run>& runs,
                                const FitOptions& options);

/// Steps of a thinned run: fine for the result, coarse while the fit is far from it.
inline constexpr double fine_step_s = 8e-3;
inline constexpr double coarse_step_s = 24e-3;

/// Thins a run for the fit to steps of about `step_s` and at most 1500 comparisons.
FitRun thin_run(const Run& run, double step_s = fine_step_s);

}  // namespace smaservo::identify
