#include "host-sim/plan/plan.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>

#include "host-sim/identify/fit/cost/all_runs_cost.hpp"
#include "host-sim/identify/fit/fit.hpp"
#include "host-sim/parallel.hpp"
#include "host-sim/plan/plan_profile.hpp"
#include "model/files/error.hpp"
#include "model/wire/plant.hpp"

namespace smaservo::plan {
namespace {

using Model = Plant<ThreePhase<double>>;

constexpr double ambient_K = room_K;
constexpr std::size_t free_runs = 3;
constexpr double free_stresses_MPa[] = {10, 25, 50, 100, 150, 200, 300, 400};
constexpr std::size_t first_recipes = 10;
constexpr std::size_t rounds = 3;
constexpr std::size_t variations = 6;  ///< variations of each run in each round
constexpr std::size_t max_comparisons = 1500;
/// The least current as a share of the greatest: enough to measure the resistance.
constexpr double min_share = 0.1;
constexpr double overheat_K = 15;
constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

/// About a sixtieth of the wire's time constant, in whole hundredths of a second.
double step_s(const Wire<double>& wire) {
  const ThermalBody<double> body = thermal_body(wire.geometry, wire.heat);
  const double fine_s = body.capacity_J_K / body.loss_W_K / 60;
  return 0.01 * std::clamp(std::floor(fine_s / 0.01), 1.0, 10.0);
}

/// The current that holds the wire 15 K above the end of its transformation, or at its limits.
double max_current_A(const Wire<double>& wire, double stress_Pa) {
  const Model::Params params = plant_params(wire);
  const Isobar<double> m2a = isobar(wire.kinetics.m2a, stress_Pa);
  const double hot_K =
      std::min(m2a.start_K + 1 / m2a.per_K + overheat_K, wire.limits.temperature_K - plan_margin_K);
  Model::State state = Model::rest(params, {ambient_K, stress_Pa});
  ThreePhase<double>::advance(params.kinetics, state.kinetics, {hot_K, stress_Pa});
  const double ohm = Model::resistance_ohm(params, state, ambient_K);
  const double power_W = std::max(0.0, params.body.loss_W(hot_K - ambient_K));
  return std::min(std::sqrt(power_W / ohm), plan_current * wire.limits.current_A);
}

struct Driven {
  PlannedRun run;
  std::vector<double> power_W;
};

Driven drive(const Wire<double>& wire, double stress_Pa, const std::vector<double>& levels,
             double peak_A, double dt_s) {
  const Model::Params params = plant_params(wire);
  Model::State state = Model::rest(params, {ambient_K, stress_Pa});
  Driven driven;
  driven.run.stress_Pa = stress_Pa;
  for (const double level : levels) {
    const double min = min_share * min_share;
    const double current_A = peak_A * std::sqrt(min + (1 - min) * level);
    const double ohm = Model::resistance_ohm(params, state, ambient_K);
    driven.power_W.push_back(current_A * current_A * ohm);
    Model::advance(params, state, {driven.power_W.back(), stress_Pa, ambient_K}, dt_s);
    driven.run.current_A.push_back(current_A);
    driven.run.temperature_K.push_back(Model::temperature_K(state));
    driven.run.strain.push_back(Model::strain(params, state));
  }
  return driven;
}

/// The deviations that a fit to runs of this wire would leave.
class Expectation {
 public:
  Expectation(const Wire<double>& wire, double dt_s)
      : wire_(wire),
        dt_s_(dt_s),
        variant_{.separate_r2a = wire.kinetics.separate_r2a,
                 .separate_r2m = wire.kinetics.separate_r2m,
                 .memory = wire.kinetics.memory,
                 .taper = identify::has_taper(wire),
                 .loop_order = identify::has_loop_order(wire),
                 .mixture = wire.material.mixture},
        problem_{wire_,
                 variant_,
                 identify::fit_parameters(wire_, variant_),
                 {{without(0), without(1)}}} {}

  const std::vector<identify::FitParameter>& parameters() const { return problem_.parameters; }

  /// JᵀJ of the wire's parameters, less the information that the run needs for its own parameters.
  Eigen::MatrixXd information(const Driven& driven) const {
    identify::FitRun run = fit_run(driven);
    const identify::Assumed<double> truth{wire_, {0, 1}, {ambient_K, 1, 0, 1, 1, 0}};
    std::vector<identify::Predicted<double>> predicted;
    identify::predict(run, truth, identify::path_of(run, truth), predicted);
    for (const identify::Predicted<double>& p : predicted) {
      run.strain.push_back(p.strain);
      run.resistance_ohm.push_back(p.resistance_ohm);
    }
    const identify::Weights weights;
    const identify::RunCost cost(problem_, run, circumstances_, weights);
    std::vector<double> u(cost.size(), 0.0);
    const std::size_t wires = problem_.parameters.size();
    std::vector<identify::Active> active;
    active.reserve(wires + identify::circumstance_count);
    for (std::size_t i = 0; i < wires; ++i) {
      active.push_back({&u[i], i, {}});
    }
    for (const int own : {identify::iAmbient, identify::iLoss, identify::iZero, identify::iGain}) {
      const std::size_t i = wires + identify::circuit_count + static_cast<std::size_t>(own);
      active.push_back({&u[i], i, {}});
    }
    const identify::AllRunsCost all({{cost, u, 0}}, identify::RiseCost(problem_), active, 1);
    const auto n = static_cast<Eigen::Index>(wires);
    const auto own = static_cast<Eigen::Index>(active.size()) - n;
    const Eigen::MatrixXd full = all.information(identify::values(active));
    const Eigen::MatrixXd coupling = full.topRightCorner(n, own);
    // The matrix of each run contains the prior, which may be counted only once in total.
    return full.topLeftCorner(n, n) - Eigen::MatrixXd::Identity(n, n) -
           coupling * full.bottomRightCorner(own, own).llt().solve(coupling.transpose());
  }

 private:
  /// A parameter that is known: its deviation has no effect.
  static identify::FitParameter without(double value) {
    return {"", "", 1, identify::Form::sum, value, 0};
  }

  identify::FitRun fit_run(const Driven& driven) const {
    const std::size_t steps = driven.power_W.size();
    identify::FitRun run;
    run.kind = identify::RunKind::joule;
    run.dt_s.assign(steps, dt_s_);
    run.power_W = driven.power_W;
    for (const double current_A : driven.run.current_A) {
      run.current2_A2.push_back(current_A * current_A);
    }
    run.stress_Pa.assign(steps, driven.run.stress_Pa);
    run.ambient_K = ambient_K;
    const std::size_t every = (steps + max_comparisons - 1) / max_comparisons;
    for (std::size_t i = every - 1; i < steps; i += every) {
      run.after.push_back(i);
    }
    run.has_strain = run.has_resistance = true;
    return run;
  }

  const Wire<double>& wire_;
  double dt_s_;
  identify::FitVariant variant_;
  identify::FitProblem problem_;
  /// The run's own parameters as in a fit, with a measured ambient temperature. Load cell and leads
  /// are known.
  identify::CircumstanceParameters circumstances_{
      {{"ambient", "degC", 1, identify::Form::sum, ambient_K, 0.5},
       {"loss", "", 1, identify::Form::factor, 1, 0.05},
       {"strain_zero", "%", 0.01, identify::Form::sum, 0, 0.02},
       {"resistance_gain", "", 1, identify::Form::factor, 1, 0.0015},
       without(1),
       without(0)}};
};

/// The deviations of all parameters with this information, relative to those of the prior.
std::vector<double> deviations(const Eigen::MatrixXd& information) {
  const Eigen::Index n = information.rows();
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(n, n);
  const Eigen::MatrixXd covariance = (information + identity).llt().solve(identity);
  std::vector<double> all(static_cast<std::size_t>(n));
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    all[i] = std::min(1.0, std::sqrt(covariance(at, at)));
  }
  return all;
}

/// Mean logarithm of these deviations; a lower value is better.
double score(const Eigen::MatrixXd& information) {
  double sum = 0;
  const std::vector<double> all = deviations(information);
  for (const double deviation : all) {
    sum += std::log(deviation);
  }
  return sum / static_cast<double>(all.size());
}

struct Candidate {
  double stress_Pa;
  Recipe recipe;
  Driven driven;
  Eigen::MatrixXd information;
};

class Search {
 public:
  Search(const Wire<double>& wire, const PlanOptions& options)
      : wire_(wire),
        options_(options),
        dt_s_(step_s(wire)),
        steps_(static_cast<std::size_t>(std::lround(options.duration_s / dt_s_))),
        expectation_(wire, dt_s_),
        fixed_(!options.stresses_Pa.empty()),
        stresses_Pa_(options.stresses_Pa) {
    for (const double stress_MPa : free_stresses_MPa) {
      if (!fixed_ && 1e6 * stress_MPa <= wire.limits.stress_Pa) {
        stresses_Pa_.push_back(1e6 * stress_MPa);
      }
    }
    if (stresses_Pa_.empty()) {
      stresses_Pa_ = {wire.limits.stress_Pa};
    }
    chosen_.assign(fixed_ ? stresses_Pa_.size() : std::min(free_runs, stresses_Pa_.size()), none);
    total_ = first_recipes * stresses_Pa_.size() + rounds * variations * chosen_.size();
  }

  Plan run() {
    std::mt19937_64 random(1);
    std::vector<std::pair<double, Recipe>> wanted;
    for (std::size_t i = 0; i < first_recipes; ++i) {
      for (const double stress_Pa : stresses_Pa_) {
        // The first profile is the triangle itself, so that no plan is worse than it.
        wanted.emplace_back(stress_Pa, i == 0 ? Recipe{} : random_recipe(random));
      }
    }
    add(wanted);
    choose();
    for (std::size_t round = 0; round < rounds; ++round) {
      wanted.clear();
      for (const std::size_t one : chosen_) {
        for (std::size_t i = 0; i < variations; ++i) {
          wanted.emplace_back(pool_[one].stress_Pa, varied(pool_[one].recipe, random));
        }
      }
      add(wanted);
      choose();
    }
    return result();
  }

 private:
  Candidate candidate(double stress_Pa, const Recipe& recipe) const {
    double peak_A = max_current_A(wire_, stress_Pa);
    const double hottest_K = wire_.limits.temperature_K - plan_margin_K;
    const std::vector<double> profile = levels(recipe, steps_);
    Driven driven = drive(wire_, stress_Pa, profile, peak_A, dt_s_);
    while (std::ranges::max(driven.run.temperature_K) > hottest_K) {
      peak_A *= 0.97;
      driven = drive(wire_, stress_Pa, profile, peak_A, dt_s_);
    }
    Eigen::MatrixXd information = expectation_.information(driven);
    return {stress_Pa, recipe, std::move(driven), std::move(information)};
  }

  void add(const std::vector<std::pair<double, Recipe>>& wanted) {
    const std::size_t before = pool_.size();
    pool_.resize(before + wanted.size());
    parallel(
        wanted.size(), options_.threads,
        [&](std::size_t i) { pool_[before + i] = candidate(wanted[i].first, wanted[i].second); },
        [&](std::size_t done) { options_.progress(before + done, total_); });
  }

  Eigen::MatrixXd information_without(std::size_t place) const {
    const auto n = static_cast<Eigen::Index>(expectation_.parameters().size());
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n, n);
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      if (i != place && chosen_[i] != none) {
        sum += pool_[chosen_[i]].information;
      }
    }
    return sum;
  }

  bool fits(std::size_t place, std::size_t candidate) const {
    const double stress_Pa = pool_[candidate].stress_Pa;
    if (fixed_) {
      return stress_Pa == stresses_Pa_[place];
    }
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      if (i != place && chosen_[i] != none && pool_[chosen_[i]].stress_Pa == stress_Pa) {
        return false;
      }
    }
    return true;
  }

  /// Replaces each run in turn by the profile that is best together with the other runs, until
  /// nothing changes.
  void choose() {
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t place = 0; place < chosen_.size(); ++place) {
        const Eigen::MatrixXd others = information_without(place);
        const auto score_of = [&](std::size_t i) { return score(others + pool_[i].information); };
        double best = chosen_[place] != none ? score_of(chosen_[place]) - 1e-9
                                             : std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < pool_.size(); ++i) {
          const double now = fits(place, i) ? score_of(i) : best;
          if (now < best) {
            best = now;
            chosen_[place] = i;
            changed = true;
          }
        }
      }
    }
  }

  Plan result() {
    if (!fixed_) {
      std::ranges::sort(chosen_, {}, [&](std::size_t one) { return pool_[one].stress_Pa; });
    }
    Plan plan{dt_s_, {}, {}, {}};
    const auto n = static_cast<Eigen::Index>(expectation_.parameters().size());
    Eigen::MatrixXd planned = Eigen::MatrixXd::Zero(n, n);
    Eigen::MatrixXd plain = Eigen::MatrixXd::Zero(n, n);
    for (const std::size_t one : chosen_) {
      Candidate& candidate = pool_[one];
      planned += candidate.information;
      const Driven triangle = drive(wire_, candidate.stress_Pa, levels({}, steps_),
                                    std::ranges::max(candidate.driven.run.current_A), dt_s_);
      plain += expectation_.information(triangle);
      plan.triangles.push_back(triangle.run);
      plan.runs.push_back(std::move(candidate.driven.run));
    }
    const std::vector<double> by_plan = deviations(planned);
    const std::vector<double> by_triangle = deviations(plain);
    for (std::size_t i = 0; i < by_plan.size(); ++i) {
      plan.parameters.push_back({expectation_.parameters()[i], by_triangle[i], by_plan[i]});
    }
    return plan;
  }

  const Wire<double>& wire_;
  const PlanOptions& options_;
  double dt_s_;
  std::size_t steps_;
  Expectation expectation_;
  bool fixed_;  ///< the stresses were given
  std::vector<double> stresses_Pa_;
  std::vector<Candidate> pool_;
  std::vector<std::size_t> chosen_;  ///< index in pool_ for each run
  std::size_t total_ = 0;
};

}  // namespace

std::size_t determined(const Plan& plan, double ExpectedParameter::* deviation) {
  return static_cast<std::size_t>(
      std::ranges::count_if(plan.parameters, [&](const auto& p) { return p.*deviation < 0.5; }));
}

double mean_logarithm(const Plan& plan, double ExpectedParameter::* deviation) {
  double sum = 0;
  for (const ExpectedParameter& p : plan.parameters) {
    sum += std::log(p.*deviation);
  }
  return sum / static_cast<double>(plan.parameters.size());
}

Plan plan_runs(const Wire<double>& wire, const PlanOptions& options) {
  if (!(options.duration_s >= 10 && options.duration_s <= 600)) {
    throw files::UserError(
        fmt::format("a run of {} s: must take between 10 and 600 s", options.duration_s));
  }
  for (const double stress_Pa : options.stresses_Pa) {
    if (!(stress_Pa > 0 && stress_Pa <= (1 + 1e-9) * wire.limits.stress_Pa)) {
      throw files::UserError(fmt::format(
          "a load of {:.4g} N, {:.4g} MPa: must be above 0 and at most {:.4g} N, {:.4g} MPa, "
          "wire.limits.load",
          stress_Pa * wire.geometry.area_m2(), 1e-6 * stress_Pa,
          wire.limits.stress_Pa * wire.geometry.area_m2(), 1e-6 * wire.limits.stress_Pa));
    }
    if (std::ranges::count(options.stresses_Pa, stress_Pa) > 1) {
      throw files::UserError(fmt::format("a load of {:.4g} N, {:.4g} MPa: is given twice",
                                         stress_Pa * wire.geometry.area_m2(), 1e-6 * stress_Pa));
    }
  }
  return Search(wire, options).run();
}

}  // namespace smaservo::plan
