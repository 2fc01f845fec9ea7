#include "host-sim/identify/fit/fit.hpp"

#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>

#include "host-sim/identify/fit/fit_state.hpp"
#include "host-sim/identify/fit/slopes.hpp"
#include "host-sim/identify/runs/offset.hpp"
#include "model/files/error.hpp"

namespace smaservo::identify {
namespace {

/// Bound on each deviation, in standard deviations of its prior.
constexpr double farthest = 8;
/// Another structure of the model is dropped if its first steps leave the cost above this many
/// times the present one.
constexpr double hopeless = 1.3;
/// A solution is good enough if a step reduces the cost by less than this share.
constexpr double tolerance = 3e-4;

CircumstanceParameters circumstances_of(const FitRun& run, const Run& original) {
  const bool ambient_measured = !original.ambient_K.empty();
  return {{{"ambient", "degC", 1, Form::sum, run.ambient_K, ambient_measured ? 0.5 : 3.0},
           {"loss", "", 1, Form::factor, 1, 0.05},
           {"strain_zero", "%", 0.01, Form::sum, 0, 0.02},
           {"resistance_gain", "", 1, Form::factor, 1, 0.0015},
           {"rate", "K/s", 1, Form::factor, 1.0 / 6, 1.5},
           {"power_zero", "W/kg", 1, Form::sum, run.middle_power_W_kg, 0.1 * max_power(run)}}};
}

/// A run in which a test frame pulled harder than the model can: its greatest stresses could never
/// be explained, and the fit would bend everything else towards them.
void refuse_too_great_stress(const Run& run, const Wire<double>& wire) {
  if (run.kind != RunKind::imposed) {
    return;
  }
  const double most_Pa = most_stress_Pa(wire);
  const auto above = std::ranges::count_if(run.stress_Pa, [&](double Pa) { return Pa > most_Pa; });
  constexpr double stray = 0.01;  ///< share of the rows that may be wrong readings
  if (static_cast<double>(above) <= stray * static_cast<double>(run.stress_Pa.size())) {
    return;
  }
  const double max_Pa = *std::ranges::max_element(run.stress_Pa);
  throw files::UserError(fmt::format(
      "{}: the stress reaches {:.0f} MPa; with an imposed strain the model's ends at {:.0f} MPa, "
      "1.5 "
      "times the wire's limit. If load_N and wire.diameter_um are right, raise the limit: --set "
      "wire.limits.load_N={:.3g}",
      run.name, 1e-6 * max_Pa, 1e-6 * most_Pa, max_Pa * wire.geometry.area_m2()));
}

class Watch final : public ceres::IterationCallback {
 public:
  Watch(const FitOptions& options, const std::string& stage, bool& interrupted)
      : options_(options), stage_(stage), interrupted_(interrupted) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (options_.proceed(
            {stage_, summary.iteration, summary.cost, usual_share(stage_, summary.iteration)})) {
      return ceres::SOLVER_CONTINUE;
    }
    interrupted_ = true;
    return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

 private:
  const FitOptions& options_;
  const std::string& stage_;
  bool& interrupted_;
};

/// A stage, the share of the whole fit's time at its end, and how many iterations it takes.
struct UsualStage {
  std::string_view name;
  double end;
  int iterations;
};
/// Of a fit to eight of the project's traces with one thread, which took 68 s. The values of the
/// last stage are fitted several times; the deviations follow.
constexpr UsualStage usual_stages[] = {{"calorimetry", 0.005, 7},
                                       {"level", 0.04, 7},
                                       {"all runs", 0.1, 7},
                                       {"all runs, weighed", 0.13, 5},
                                       {"R2A near A2R", 0.4, 20},
                                       {"R2A near A2R, weighed", 0.48, 5},
                                       {"R2A by itself", 0.51, 6},
                                       {"R2M by itself", 0.55, 6},
                                       {"inner loops", 0.58, 4},
                                       {"mixture", 0.62, 4},
                                       {"runs left out", 0.64, 6},
                                       {"runs left out, the others", 0.68, 6},
                                       {"ends and order", 0.85, 7},
                                       {"runs left out, ordered", 0.87, 6},
                                       {"runs left out, ordered, the others", 0.89, 6},
                                       {"what the runs determine", 0.92, 3},
                                       {"refinement", 0.96, 6},
                                       {"what the runs determine, refined", 0.98, 3},
                                       {"reported deviation", 1, 1}};

}  // namespace

double usual_share(std::string_view stage, int iteration) {
  double begin = 0;
  for (const UsualStage& usual : usual_stages) {
    // The stage of a level of stress also has the stress in its name.
    if (stage == usual.name || (usual.name == "level" && stage.starts_with("level "))) {
      const double part = std::min(1.0, iteration / static_cast<double>(usual.iterations));
      return begin + part * (usual.end - begin);
    }
    begin = usual.end;
  }
  return begin;
}

double max_power(const FitRun& run) {
  double max = 1e-9;
  for (const double power : run.power_W_kg) {
    max = std::isnan(power) ? max : std::max(max, std::abs(power - run.middle_power_W_kg));
  }
  return max;
}

double max_stress_Pa(const FitRun& run) {
  double max = 1e5;
  for (const double stress_Pa : run.measured_stress_Pa) {
    max = std::max(max, std::abs(stress_Pa));
  }
  return max;
}

Fit::Fit(const Wire<double>& from, const std::vector<Run>& runs, const FitOptions& options)
    : from_(from), runs_in_full_(runs), options_(options) {
  for (const Run& run : runs) {
    refuse_too_great_stress(run, from);
    runs_.push_back(thin_run(run, coarse_step_s));
    zero_known_.push_back(zero_known(run.strain));
    circumstances_.push_back(circumstances_of(runs_.back(), run));
    Weights weights;
    weights.power_sd = 0.03 * max_power(runs_.back());
    weights.stress_sd = 0.05 * max_stress_Pa(runs_.back());
    weights_.push_back(weights);
    first_weights_.push_back(weights);
  }
  with({.separate_r2a = from.kinetics.separate_r2a,
        .separate_r2m = from.kinetics.separate_r2m,
        .memory = from.kinetics.memory,
        .taper = has_taper(from),
        .loop_order = has_loop_order(from),
        .mixture = from.material.mixture,
        .circuit = options_.circuit,
        .wire_temperature = std::ranges::any_of(runs, [](const Run& run) {
          return run.kind == RunKind::bath || run.kind == RunKind::calorimetry;
        })});
  u_.runs.resize(runs_.size());
}

void Fit::refine() {
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    runs_[i] = thin_run(runs_in_full_[i], fine_step_s);
  }
  weigh();
}

/// Changes the model's structure. A parameter that both structures have keeps its value.
void Fit::with(const FitVariant& variant) {
  std::map<std::string, double> moved;
  if (problem_) {
    for (std::size_t i = 0; i < u_.wire.size(); ++i) {
      moved[problem_->parameters[i].key] = u_.wire[i] * problem_->parameters[i].sd;
    }
  }
  const double cold_ohm = cold_resistance_ohm(from_);
  problem_ = std::make_unique<FitProblem>(
      FitProblem{from_,
                 variant,
                 fit_parameters(from_, variant),
                 {{{"circuit.lead", "ohm", 1, Form::sum, 0, 0.02 * cold_ohm},
                   {"circuit.load_gain", "", 1, Form::factor, 1, 0.03}}}});
  u_.wire.assign(problem_->parameters.size(), 0.0);
  for (std::size_t i = 0; i < u_.wire.size(); ++i) {
    const std::string& key = problem_->parameters[i].key;
    const auto own = moved.find(key);
    // A surface that is no longer shared starts with the values of the shared one, so that the cost
    // does not rise. Its prior is narrower. An R2A that is sought near A2R starts where A2R is by
    // now; its curve is A2R's, seen from the other end.
    std::string shared = key;
    const char* const like_r2a = variant.r2a_near_a2r ? "wire.a2r." : "wire.m2a.";
    for (const auto& [to, as] :
         {std::pair{"wire.r2a.", like_r2a}, std::pair{"wire.r2m.", "wire.a2m."}}) {
      if (key.starts_with(to)) {
        shared = as + key.substr(std::string_view(to).size());
      }
    }
    const bool mirrored = variant.r2a_near_a2r && key.starts_with("wire.r2a.turning");
    const auto from = own != moved.end() ? own : moved.find(shared);
    u_.wire[i] = from != moved.end() ? (mirrored && own == moved.end() ? -1 : 1) * from->second /
                                           problem_->parameters[i].sd
                                     : 0.0;
  }
  if (!variant.circuit) {
    u_.circuit = {};
  }
}

bool Fit::circumstance_active(std::size_t i, int index) const {
  const FitRun& run = runs_[i];
  switch (index) {
    case iAmbient:
    case iLoss:
      return run.kind == RunKind::joule || run.kind == RunKind::settled ||
             run.kind == RunKind::imposed;
    case iZero:
      return run.kind == RunKind::imposed || (run.has_strain && !zero_known_[i]);
    case iGain:
      return run.has_resistance;
    case iRate:
      return run.kind == RunKind::calorimetry && run.rate_K_s.empty();
    default:
      return run.kind == RunKind::calorimetry;
  }
}

std::vector<double> Fit::deviations(std::size_t run) const {
  std::vector<double> all = u_.wire;
  all.insert(all.end(), u_.circuit.begin(), u_.circuit.end());
  all.insert(all.end(), u_.runs[run].begin(), u_.runs[run].end());
  return all;
}

std::vector<Active> Fit::active(const Runs& which, const Chosen& chosen) {
  std::vector<Active> all;
  std::size_t index = 0;
  for (double& u : u_.wire) {
    if (chosen(problem_->parameters[index].key)) {
      all.push_back({&u, index, {}});
    }
    ++index;
  }
  for (double& u : u_.circuit) {
    if (problem_->variant.circuit) {
      all.push_back({&u, index, {}});
    }
    ++index;
  }
  for (const std::size_t run : which) {
    for (int k = 0; k < circumstance_count; ++k) {
      const auto own = static_cast<std::size_t>(k);
      if (circumstance_active(run, k)) {
        all.push_back({&u_.runs[run][own], index + own, run});
      }
    }
  }
  return all;
}

Fit::Chosen Fit::free_of(const Chosen& chosen) const {
  return [this, chosen](const std::string& key) { return chosen(key) && !kept_.contains(key); };
}

AllRunsCost Fit::all_runs_cost(const Runs& which, const std::vector<Active>& active) const {
  std::vector<AllRunsCost::One> runs;
  for (const std::size_t i : which) {
    runs.push_back({run_cost(i), deviations(i), i});
  }
  return {std::move(runs), RiseCost(*problem_), active, options_.threads};
}

double Fit::solve(const std::string& stage, const Runs& which, const Chosen& chosen,
                  int iterations) {
  if (interrupted_) {
    return cost(which);
  }
  const std::vector<Active> changing = active(which, free_of(chosen));
  if (changing.empty()) {
    converged_ = true;
    return this->cost(which);
  }
  AllRunsCost cost = all_runs_cost(which, changing);
  std::vector<double> x = values(changing);
  std::ranges::transform(x, x.begin(), [](double u) { return std::clamp(u, -farthest, farthest); });
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  problem.AddResidualBlock(&cost, nullptr, x.data());
  for (int i = 0; i < static_cast<int>(x.size()); ++i) {
    problem.SetParameterLowerBound(x.data(), i, -farthest);
    problem.SetParameterUpperBound(x.data(), i, farthest);
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  solver.function_tolerance = tolerance;
  solver.logging_type = ceres::SILENT;
  Watch watch(options_, stage, interrupted_);
  solver.callbacks.push_back(&watch);
  // The path through the hysteresis reverses at thresholds, so the cost has kinks, at which the
  // steps become too small to continue. A restart with large steps leaves a kink. It is repeated
  // while it lowers the cost by 3 %.
  double before = std::numeric_limits<double>::infinity();
  int left = iterations;
  converged_ = false;
  ceres::Solver::Summary summary;
  do {
    solver.max_num_iterations = left;
    ceres::Solve(solver, &problem, &summary);
    const int done = std::max(1, static_cast<int>(summary.iterations.size()) - 1);
    iterations_ += done;
    left -= done;
    if (!(summary.final_cost < 0.97 * before)) {
      converged_ = true;
      break;
    }
    before = summary.final_cost;
  } while (left > 0 && !interrupted_);
  for (std::size_t i = 0; i < x.size(); ++i) {
    *changing[i].value = x[i];
  }
  return summary.final_cost;
}

/// The cost that solve() minimises, at the deviations found so far.
double Fit::cost(const Runs& which) {
  const std::vector<Active> changing = active(which, all);
  const AllRunsCost cost = all_runs_cost(which, changing);
  const std::vector<double> x = values(changing);
  std::vector<double> residuals(static_cast<std::size_t>(cost.num_residuals()));
  const double* const block = x.data();
  cost.Evaluate(&block, residuals.data(), nullptr);
  double sum = 0;
  for (const double r : residuals) {
    sum += 0.5 * r * r;
  }
  return sum;
}

/// Fits all runs and weighs them; the weights before do not matter.
void Fit::fit_all(const std::string& name) {
  weights_ = first_weights_;
  weighed_ = false;
  joint(name, options_.max_iterations);
  weigh();
  joint(name + ", weighed", options_.max_iterations);
}

/// Fits an R2A that is sought near A2R, from the same start as the fit of all runs. R-phase that
/// goes to austenite far below martensite leaves that fit in a local minimum, where the resistance
/// fits badly and therefore weighs little: no structure that begins there gets out of it.
void Fit::try_r2a_near_a2r(const Deviations& start) {
  const auto calorimetry = [](const FitRun& run) { return run.kind == RunKind::calorimetry; };
  if (interrupted_ || std::ranges::all_of(runs_, calorimetry)) {
    return;
  }
  const FitVariant variant = problem_->variant;
  const Deviations found = u_;
  const std::vector<Weights> weights = weights_;
  const Unexplained before = unexplained();
  u_ = start;
  FitVariant near = variant;
  near.separate_r2a = near.r2a_near_a2r = true;
  with(near);
  fit_all("R2A near A2R");
  const double additional = variant.separate_r2a ? 0 : 9;
  if (interrupted_ || gain(before, unexplained()) < additional) {
    with(variant);
    u_ = found;
    weights_ = weights;
  }
}

/// Tries other structures of the model, one after the other. A structure is kept if it lowers the
/// cost by more than its additional parameters would by fitting noise.
void Fit::try_variants() {
  const auto attempt = [&](const std::string& name, double additional, auto change) {
    FitVariant variant = problem_->variant;
    change(variant);
    if (interrupted_ || variant == problem_->variant) {
      return;
    }
    const FitVariant old = problem_->variant;
    const Deviations old_u = u_;
    const double before = cost(everything());
    with(variant);
    // The first steps show whether the structure is promising.
    const int first = std::max(1, options_.max_iterations / 13);
    double after = joint(name, first);
    if (after < hopeless * before) {
      after = joint(name, options_.max_iterations / 5 - first);
    }
    if (interrupted_ || before - after < additional) {
      with(old);
      u_ = old_u;
    } else {
      weigh();
    }
  };
  const auto has = [&](bool FitRun::* channel) {
    return std::ranges::any_of(runs_, [&](const FitRun& run) { return run.*channel; });
  };
  attempt("R2A by itself", 9, [](FitVariant& v) { v.separate_r2a = true; });
  attempt("R2M by itself", 9, [](FitVariant& v) { v.separate_r2m = true; });
  attempt("inner loops", 4, [](FitVariant& v) {
    v.memory = v.memory == Memory::plain ? Memory::return_point : Memory::plain;
    v.loop_order = v.loop_order && v.memory == Memory::return_point;
  });
  if (has(&FitRun::has_resistance)) {
    attempt("mixture", 2, [](FitVariant& v) {
      v.mixture = v.mixture == Mixture::series ? Mixture::parallel : Mixture::series;
    });
  }
}

/// Fits the ends of the curves and the order of the loops.
void Fit::fit_order() {
  if (interrupted_) {
    return;
  }
  simpler_strain_sd_ = weights_.front().strain_sd;
  from_.kinetics = ordered_before(from_.kinetics, problem_->variant.memory);
  FitVariant ordered = problem_->variant;
  ordered.taper = true;
  ordered.loop_order = ordered.memory == Memory::return_point;
  with(ordered);
  joint("ends and order", options_.max_iterations / 2);
  weigh();
}

double Fit::start() {
  calorimetry();
  stress_levels();
  // One by one, runs of a wire that is not known yet would find it far apart.
  find_zero(imposed_runs());
  return cost(everything());
}

FitResult Fit::run() {
  start();
  const Deviations start = u_;
  fit_all("all runs");
  if (options_.variants) {
    try_r2a_near_a2r(start);
    try_variants();
  }
  choose_structure();
  // The coarse steps show most of what the runs do not determine, in a third of the time that fine
  // ones take.
  settle("what the runs determine");
  refine();
  joint("refinement", options_.max_iterations);
  settle("what the runs determine, refined");
  rise();
  FitResult result;
  describe(result);
  uncertainty(result);
  return result;
}

FitResult fit_wire(const Wire<double>& from, const std::vector<Run>& runs,
                   const FitOptions& options) {
  if (runs.empty()) {
    throw files::UserError("identify: there is no run to fit to");
  }
  for (const auto& [process, surface] : surfaces(from)) {
    if (steepest_fall_K_Pa(surface, from.limits.stress_Pa) > 0) {
      throw files::UserError(
          fmt::format("{}: its start or finish temperature falls with stress; give a --from wire "
                      "where both rise or stay",
                      process));
    }
  }
  const double offset_K = transitions_offset_K(from, runs);
  if (offset_K == 0) {
    return Fit(from, runs, options).run();
  }
  const Wire<double> there = moved(from, offset_K);
  const bool better = Fit(there, runs, options).start() < Fit(from, runs, options).start();
  FitResult result = Fit(better ? there : from, runs, options).run();
  result.moved_K = better ? offset_K : 0;
  return result;
}

}  // namespace smaservo::identify
