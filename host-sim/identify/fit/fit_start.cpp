// The start of a fit, in paper 000's stages: transitions at zero stress, then each level of stress,
// then the dependence on stress.

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <limits>
#include <map>

#include "host-sim/identify/fit/fit_state.hpp"

namespace smaservo::identify {
namespace {

/// Whether a single level of stress can determine the deviation. The parameters of heating and
/// cooling are left to all levels together: one level alone cannot tell a warmer transition from a
/// smaller loss.
bool of_level(const std::string& key) {
  return (is_of_process(key) && (key.ends_with(".temperature") || key.ends_with(".width"))) ||
         key == "wire.martensite.strain" || key == "wire.martensite.resistivity" ||
         key.ends_with(".resistivity_ratio");
}

}  // namespace

/// Groups the runs at nearly constant stress by level.
std::vector<Fit::Runs> Fit::levels() const {
  std::map<long, Runs> found;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    if (runs_[i].kind == RunKind::calorimetry || runs_[i].kind == RunKind::imposed) {
      continue;
    }
    const auto [low, high] = std::ranges::minmax(runs_[i].stress_Pa);
    if (high - low < std::max(20e6, 0.3 * high)) {
      found[std::lround((low + high) / 2 / 15e6)].push_back(i);
    }
  }
  std::vector<Runs> all;
  all.reserve(found.size());
  for (auto& [stress, which] : found) {
    all.push_back(std::move(which));
  }
  return all;
}

/// 000, stage 1: transitions and shape at zero stress.
void Fit::calorimetry() {
  Runs which;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    if (runs_[i].kind == RunKind::calorimetry) {
      which.push_back(i);
    }
  }
  if (which.empty()) {
    return;
  }
  solve(
      "calorimetry", which,
      [](const std::string& key) {
        return (is_of_process(key) && !key.ends_with("_stress") && !key.ends_with("_bend")) ||
               key.starts_with("wire.heat.latent") || key == "wire.heat.specific_heat";
      },
      options_.max_iterations);
}

/// Tries shifted transitions: if the model's transition is more than its width away from the
/// wire's, the fit would end in a local minimum.
void Fit::start_at_level(const Runs& level) {
  const auto index = [&](const std::string& key) {
    return static_cast<std::size_t>(
        std::ranges::find(problem_->parameters, key, &FitParameter::key) -
        problem_->parameters.begin());
  };
  const std::size_t m2a = index("wire.m2a.temperature");
  const std::size_t a2m = index("wire.a2m.temperature");
  const Deviations before = u_;
  Deviations best = u_;
  double min = std::numeric_limits<double>::infinity();
  for (const double heating : {0.0, -0.75, 0.75, -1.5, 1.5, -2.5, 2.5}) {
    for (const double cooling : {0.0, -0.75, 0.75, -1.5, 1.5, -2.5, 2.5}) {
      u_ = before;
      u_.wire[m2a] += heating;
      u_.wire[a2m] += cooling;
      const double now = cost(level);
      if (now < min) {
        min = now;
        best = u_;
      }
    }
  }
  u_ = best;
}

/// 000, stages 2 and 3: each level of stress separately, then the dependence of the values on
/// stress.
void Fit::stress_levels() {
  const std::vector<Runs> all_levels = levels();
  if (all_levels.empty()) {
    return;
  }
  const Deviations before = u_;
  std::vector<FoundLevel> found;
  for (const Runs& level : all_levels) {
    u_ = before;
    const FitRun& first = runs_[level.front()];
    const double stress_Pa = std::accumulate(first.stress_Pa.begin(), first.stress_Pa.end(), 0.0) /
                             static_cast<double>(first.stress_Pa.size());
    start_at_level(level);
    solve(fmt::format("level of {:.0f} MPa", stress_Pa * 1e-6), level, of_level, 12);
    found.push_back({stress_Pa, u_});
  }
  u_ = before;
  for (std::size_t k = 0; k < all_levels.size(); ++k) {
    for (const std::size_t i : all_levels[k]) {
      u_.runs[i] = found[k].u.runs[i];
    }
  }
  for (std::size_t i = 0; i < problem_->parameters.size(); ++i) {
    if (of_level(problem_->parameters[i].key)) {
      join_levels(i, before, found);
    }
  }
}

Fit::Runs Fit::imposed_runs() const {
  Runs imposed;
  std::ranges::copy_if(everything(), std::back_inserter(imposed),
                       [&](std::size_t i) { return runs_[i].kind == RunKind::imposed; });
  return imposed;
}

/// Tries zeros of imposed strains, the same one for all of these runs: a test frame counts from
/// where its wire was clamped. Far from the true one the model's wire hangs slack or tears, and no
/// derivative leads back.
void Fit::find_zero(const Runs& imposed) {
  constexpr double lowest = -0.08, highest = 0.04, step = 0.0025;
  if (imposed.empty()) {
    return;
  }
  const auto set = [&](double zero) {
    for (const std::size_t i : imposed) {
      u_.runs[i][iZero] = zero / circumstances_[i][iZero].sd;
    }
  };
  double best = 0;
  double min = std::numeric_limits<double>::infinity();
  for (double zero = lowest; zero < highest; zero += step) {
    set(zero);
    if (const double now = cost(imposed); now < min) {
      min = now;
      best = zero;
    }
  }
  set(best);
}

/// What a value at a level of stress consists of: the deviation of each parameter that has a part
/// in it, times a function of the stress.
std::vector<StressPart> Fit::stress_parts(std::size_t i) const {
  const std::vector<FitParameter>& parameters = problem_->parameters;
  const std::string& key = parameters[i].key;
  std::vector<StressPart> parts{{i, [](double) { return 1.0; }}};
  if (!is_of_process(key)) {
    return parts;
  }
  const double max_Pa = from_.limits.stress_Pa;
  const double sd = parameters[i].sd;
  const double sd_1 = parameters[i + 1].sd;
  if (!key.ends_with(".temperature")) {
    parts.push_back({i + 1, [=](double stress) { return sd_1 * stress / max_Pa / sd; }});
    return parts;
  }
  const double sd_2 = parameters[i + 2].sd;
  parts.push_back({i + 1, [=](double stress) { return sd_1 * stress / sd; }});
  parts.push_back({i + 2, [=](double stress) {
                     const double s = stress / max_Pa;
                     return 4 * sd_2 * s * (1 - s) / sd;
                   }});
  return parts;
}

/// Finds a parameter and its dependence on stress from its values at the levels, by least squares:
/// value(σ) = u sd + (contribution of stress); each level has seen the sum of both.
void Fit::join_levels(std::size_t i, const Deviations& before,
                      const std::vector<FoundLevel>& found) {
  const std::vector<StressPart> parts = stress_parts(i);
  const auto n = static_cast<Eigen::Index>(parts.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Identity(n, n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  for (const FoundLevel& level : found) {
    Eigen::VectorXd row(n);
    for (Eigen::Index c = 0; c < n; ++c) {
      row[c] = parts[static_cast<std::size_t>(c)].of_stress(level.stress_Pa);
    }
    constexpr double trust = 400;  // a level's value has a twentieth of the prior's sd
    normal += trust * row * row.transpose();
    right += trust * row * (level.u.wire[i] - before.wire[i]);
  }
  const Eigen::VectorXd solution = normal.llt().solve(right);
  for (Eigen::Index c = 0; c < n; ++c) {
    const std::size_t k = parts[static_cast<std::size_t>(c)].parameter;
    u_.wire[k] = before.wire[k] + solution[c];
  }
}

}  // namespace smaservo::identify
