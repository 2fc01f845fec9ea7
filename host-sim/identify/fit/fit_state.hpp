#pragma once
// A fit in progress: its runs, their weights, and the present values of its parameters, each as a
// deviation from the wire at the start (parameters.hpp). Used only inside the fit. fit.cpp solves,
// fit_start.cpp finds a start, fit_kept.cpp resets the parameters that the runs do not determine,
// fit_result.cpp computes the remaining errors and the uncertainties.

#include <array>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host-sim/identify/fit/cost/all_runs_cost.hpp"
#include "host-sim/identify/fit/cost/run_cost.hpp"
#include "host-sim/identify/fit/fit.hpp"
#include "host-sim/identify/fit/judge/observed_run.hpp"
#include "host-sim/identify/fit/spread.hpp"

namespace smaservo::identify {

/// The values of all parameters of a fit, as deviations (parameters.hpp).
struct Deviations {
  std::vector<double> wire;
  std::array<double, circuit_count> circuit{};
  std::vector<std::array<double, circumstance_count>> runs;
};

/// What a level of stress has found by itself.
struct FoundLevel {
  double stress_Pa;
  Deviations u;
};

/// A parameter's part in a value at a level of stress: its deviation times a function.
struct StressPart {
  std::size_t parameter;
  std::function<double(double stress_Pa)> of_stress;
};

/// What a fit leaves unexplained: the remaining errors of all channels, as the weights that follow
/// from them, and half the sum of the squared deviations.
struct Unexplained {
  std::vector<Weights> errors;
  double prior;
};

/// By how much the second of two fits to the same runs is the likelier one, in natural logarithms.
/// The errors count as Gaussian, and as independent where the fit that finds less of them
/// independent says so.
double gain(const Unexplained& from, const Unexplained& to);

class Fit {
 public:
  Fit(const Wire<double>& from, const std::vector<Run>& runs, const FitOptions& options);

  FitResult run();
  /// The cost after the first stages, which find each stress by itself.
  double start();
  Deviations known_circumstances();
  std::vector<FittedRun> predicted(const Deviations& known);

 private:
  using Runs = std::vector<std::size_t>;

  /// Selects the wire's deviations that a stage may change.
  using Chosen = std::function<bool(const std::string& key)>;
  static bool all(const std::string& /*key*/) { return true; }

  Runs everything() const {
    Runs which(runs_.size());
    std::iota(which.begin(), which.end(), std::size_t{0});
    return which;
  }

  // fit.cpp
  void with(const FitVariant& variant);
  bool circumstance_active(std::size_t i, int index) const;
  RunCost run_cost(std::size_t run) const {
    return {*problem_, runs_[run], circumstances_[run], weights_[run]};
  }
  /// The deviations that a run's cost depends on.
  std::vector<double> deviations(std::size_t run) const;
  std::vector<Active> active(const Runs& which, const Chosen& chosen);
  /// Selects from `chosen` the deviations that stages may still change.
  Chosen free_of(const Chosen& chosen) const;
  AllRunsCost all_runs_cost(const Runs& which, const std::vector<Active>& active) const;
  /// Returns the cost after solving.
  double solve(const std::string& stage, const Runs& which, const Chosen& chosen, int iterations);
  double joint(const std::string& stage, int iterations) {
    return solve(stage, everything(), all, iterations);
  }
  double cost(const Runs& which);
  void fit_all(const std::string& name);
  void try_r2a_near_a2r(const Deviations& start);
  void try_variants();
  void fit_order();
  /// Replaces the coarsely thinned runs by finely thinned ones.
  void refine();

  // judge/fit_choice.cpp
  /// A run, and a fit with whose wire the observer is judged in it.
  struct Seen {
    std::size_t run;
    Assumed<double> as_fitted;
  };
  Runs judgeable() const;
  Seen seen(std::size_t run) const;
  std::vector<Seen> unseen(const std::string& stage);
  std::vector<ObserverErrors> errors(const std::vector<Seen>& wires, double strain_sd) const;
  JudgedStructure judge(Structure structure, const JudgedStructure* to_beat);
  void choose_structure();
  struct Honest {
    double strain_sd, share_within_2_sd;
  };
  Honest honest_strain_sd(double fitted_sd);

  // fit_kept.cpp
  Eigen::MatrixXd covariance(const std::vector<Active>& changing) const;
  bool is_of_wire(const Active& one) const { return one.index < problem_->parameters.size(); }
  bool keep_undetermined(Spread& spread);
  void settle(const std::string& stage);
  void rise();
  Wire<double> restored(const Wire<double>& wire) const;

  // fit_start.cpp
  void calorimetry();
  std::vector<Runs> levels() const;
  void start_at_level(const Runs& level);
  void stress_levels();
  Runs imposed_runs() const;
  void find_zero(const Runs& imposed);
  std::vector<StressPart> stress_parts(std::size_t i) const;
  void join_levels(std::size_t i, const Deviations& before, const std::vector<FoundLevel>& found);

  // fit_result.cpp
  void apportion(std::size_t i);
  void weigh();
  Unexplained unexplained();
  FittedRun fitted(std::size_t i);
  FittedRun judged(std::size_t i, std::size_t first);
  void accuracy(Accuracy<double>& of) const;
  void describe(FitResult& result);
  void uncertainty(FitResult& result);

  Wire<double> from_;  ///< the problem refers to it
  const std::vector<Run>& runs_in_full_;
  FitOptions options_;
  std::vector<FitRun> runs_;
  std::vector<bool> zero_known_;
  std::vector<CircumstanceParameters> circumstances_;
  std::vector<Weights> first_weights_;  ///< before the residuals are known
  std::vector<Weights> weights_;
  bool weighed_ = false;  ///< the weights come from residuals, not from the initial assumptions
  std::unique_ptr<FitProblem> problem_;
  Deviations u_;
  /// Keys of parameters that no stage changes any more: they have their values from before the fit.
  std::set<std::string> kept_;
  /// Keys of parameters without which the fit was clearly worse.
  std::set<std::string> needed_;
  Judgement judgement_;
  /// The judged runs with wires of the chosen structure that were fitted without them.
  std::vector<Seen> unseen_;
  /// Error of the strain that was left before ends and order were fitted; 0 if they were not.
  double simpler_strain_sd_ = 0;
  bool interrupted_ = false;
  bool converged_ = true;  ///< result of the last solve()
  int iterations_ = 0;
};

/// The greatest stress that was measured with an imposed strain; at least 0.1 MPa.
double max_stress_Pa(const FitRun& run);
/// The greatest distance of the heat flow from its middle; just above 0 where there is none.
double max_power(const FitRun& run);

}  // namespace smaservo::identify
