// Sets parameters that the runs do not determine back to their values before the fit, and fits the
// remaining ones again.

#include <Eigen/Cholesky>
#include <algorithm>
#include <iterator>
#include <optional>

#include "host-sim/identify/fit/fit_state.hpp"
#include "host-sim/identify/fit/slopes.hpp"
#include "model/wire/wire_parameters.hpp"

namespace smaservo::identify {
namespace {

/// A parameter is determined if its standard deviation after the fit is below this share of the
/// prior's.
constexpr double most_of_prior = 0.5;
/// A parameter is also determined if it has moved from the prior by this many of its standard
/// deviations after the fit.
constexpr double surely_moved = 2;

}  // namespace

/// The covariance of these deviations, by the runs and the prior. Correlated rows count as fewer.
/// The cost of falling transitions is left out: only the runs determine a parameter.
Eigen::MatrixXd Fit::covariance(const std::vector<Active>& changing) const {
  const auto width = static_cast<Eigen::Index>(changing.size());
  return all_runs_cost(everything(), changing)
      .information(values(changing))
      .llt()
      .solve(Eigen::MatrixXd::Identity(width, width));
}

/// Sets the least determined parameter back to its prior, repeatedly, until all others are
/// determined. If the runs determine parameters only in combination, such as a temperature and its
/// slope under a single load, the better known one stays free. Returns whether any was set back.
bool Fit::keep_undetermined(Spread& spread) {
  bool any = false;
  for (;;) {
    std::optional<std::size_t> worst;
    for (std::size_t i = 0; i < spread.size(); ++i) {
      const double variance = spread.variance(i);
      const Active& one = spread.active(i);
      const bool stays = !is_of_wire(one) ||
                         needed_.contains(problem_->parameters[one.index].key) ||
                         variance < most_of_prior * most_of_prior ||
                         *one.value * *one.value > surely_moved * surely_moved * variance;
      if (!stays && (!worst || variance > spread.variance(*worst))) {
        worst = i;
      }
    }
    if (!worst) {
      return any;
    }
    spread.hold(*worst, 0);
    kept_.insert(problem_->parameters[spread.active(*worst).index].key);
    any = true;
  }
}

/// Sets parameters back and fits the others again, until all others are determined. If the fit then
/// is clearly worse, the parameters that were set back are needed and become free again.
void Fit::settle(const std::string& stage) {
  for (;;) {
    const std::vector<Active> changing = active(everything(), free_of(all));
    const double before = cost(everything());
    const Deviations found = u_;
    const std::set<std::string> kept_before = kept_;
    Spread spread(changing, covariance(changing));
    if (!keep_undetermined(spread)) {
      return;
    }
    const double after = joint(stage, options_.max_iterations);
    const auto taken = static_cast<double>(kept_.size() - kept_before.size());
    if (after - before > 0.5 * surely_moved * surely_moved * taken) {
      // The covariance, which assumes a linear model, had predicted a smaller rise of the cost.
      std::ranges::set_difference(kept_, kept_before, std::inserter(needed_, needed_.end()));
      kept_ = kept_before;
      u_ = found;
    }
  }
}

/// If the runs demand it, the fit lets a transition fall by some thousandths of a K/MPa. This adds
/// the same amount to its slope.
void Fit::rise() {
  std::size_t next = 0;
  const auto now = [&](const FitParameter& parameter) { return parameter.value(u_.wire[next++]); };
  const Wire<double> wire = vary_wire<double>(problem_->from, problem_->variant, now);
  for (const auto& [process, surface] : surfaces(wire)) {
    const double fall_K_Pa = steepest_fall_K_Pa(surface, from_.limits.stress_Pa);
    if (fall_K_Pa > 0) {
      const auto slope = std::ranges::find(problem_->parameters, process + ".temperature_stress",
                                           &FitParameter::key);
      kept_.erase(slope->key);
      u_.wire[static_cast<std::size_t>(slope - problem_->parameters.begin())] +=
          1.000001 * fall_K_Pa / slope->sd;
    }
  }
}

/// The wire with the structure that was found. Reals that no deviation has moved are copied from
/// the wire before the fit, because computing them again would round them. An R2A that was sought
/// near A2R has nothing from there.
Wire<double> Fit::restored(const Wire<double>& wire) const {
  const Wire<double> unmoved =
      vary_wire<double>(problem_->from, problem_->variant,
                        [](const FitParameter& parameter) { return parameter.value(0.0); });
  Wire<double> now = wire;
  const bool own_r2a = !problem_->variant.r2a_near_a2r;
  for (const WireParameter<double>& row : wire_parameters<double>) {
    const bool from_before = own_r2a || row.needs != Needs::own_r2a;
    if (from_before && row.type == ValueType::real && row.is_used(from_) && row.is_used(wire) &&
        row.get(wire) == row.get(unmoved)) {
      row.set(now, row.get(from_));
    }
  }
  return now;
}

}  // namespace smaservo::identify
