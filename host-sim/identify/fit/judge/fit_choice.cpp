// The choice of a structure, and the observer's accuracy, by runs that a fit has not seen.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "host-sim/identify/fit/fit_state.hpp"
#include "host-sim/identify/fit/judge/observed_run.hpp"
#include "host-sim/parallel.hpp"

namespace smaservo::identify {
namespace {

/// A structure with more parameters is chosen if the observer errs by less than this share.
constexpr double clearly_less = 0.9;
/// Greatest factor on the accuracy of the strain, and its steps.
constexpr double most_factor = 4, factor_step = 1.1;
/// Share of the errors within twice the reported deviation that is aimed at.
constexpr double aimed_within_2_sd = 0.954;

bool clearly_better(const std::vector<double>& errors, const std::vector<double>& than) {
  return !errors.empty() && mean_error(errors) < clearly_less * mean_error(than);
}

/// Whether there are strains that an observer can be compared with.
bool has_late_strain(const Run& run) {
  for (std::size_t i = 0; i < run.strain.size(); ++i) {
    if (run.time_s[i] - run.time_s.front() > 2 * observer_settles_s && !std::isnan(run.strain[i])) {
      return true;
    }
  }
  return false;
}

double mean_stress_Pa(const FitRun& run) {
  return std::accumulate(run.stress_Pa.begin(), run.stress_Pa.end(), 0.0) /
         static_cast<double>(run.stress_Pa.size());
}

}  // namespace

/// The runs in which an observer can be judged, by rising stress.
Fit::Runs Fit::judgeable() const {
  Runs which;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    if (runs_[i].kind == RunKind::joule && runs_[i].has_resistance &&
        has_late_strain(runs_in_full_[i])) {
      which.push_back(i);
    }
  }
  std::ranges::sort(which, {},
                    [&](std::size_t i) { return std::pair(mean_stress_Pa(runs_[i]), i); });
  return which;
}

/// The wire as it is fitted now, for the observer in this run.
Fit::Seen Fit::seen(std::size_t run) const {
  const std::vector<double> u = deviations(run);
  Assumed<double> assumed = run_cost(run).assumed<double>(u.data());
  accuracy(assumed.wire.accuracy);
  return {run, assumed};
}

/// For each of the judged runs the wire of a fit that has not seen it. There are two halves, of
/// every second run by stress; each is left out of a fit to all other runs, which starts from the
/// present one. What belongs to the run alone, such as its air, is that of the present fit.
std::vector<Fit::Seen> Fit::unseen(const std::string& stage) {
  const Deviations whole = u_;
  const Runs& judged = judgement_.runs;
  std::vector<Seen> all;
  for (const std::size_t half : {std::size_t{0}, std::size_t{1}}) {
    u_ = whole;
    Runs others = everything();
    for (std::size_t i = half; i < judged.size(); i += 2) {
      std::erase(others, judged[i]);
    }
    solve(half == 0 ? stage : stage + ", the others", others, Fit::all,
          options_.max_iterations / 6);
    for (std::size_t i = half; i < judged.size(); i += 2) {
      all.push_back(seen(judged[i]));
    }
  }
  u_ = whole;
  std::ranges::sort(all, {}, [&](const Seen& one) {
    return std::ranges::find(judged, one.run) - judged.begin();
  });
  return all;
}

/// How the observer errs with these wires if their accuracy of the strain is this, in their order.
std::vector<ObserverErrors> Fit::errors(const std::vector<Seen>& wires, double strain_sd) const {
  std::vector<ObserverErrors> all(wires.size());
  parallel(
      wires.size(), options_.threads,
      [&](std::size_t i) {
        const auto& [run, as_fitted] = wires[i];
        Wire<double> wire = as_fitted.wire;
        wire.accuracy.strain = strain_sd;
        all[i] = observer_errors(observed_run(runs_in_full_[run], as_fitted), wire);
      },
      [](std::size_t /*done*/) {});
  return all;
}

/// The errors of the structure that is fitted now: in all runs, with the wire that was fitted to
/// them; and in each half of them, with a wire that was fitted without it. The latter are left out
/// where the former are not clearly less than `to_beat`.
JudgedStructure Fit::judge(Structure structure, const JudgedStructure* to_beat) {
  const double sd = weights_[judgement_.runs.front()].strain_sd;
  const auto means = [&](const std::vector<Seen>& wires) {
    std::vector<double> all;
    for (const ObserverErrors& of_run : errors(wires, sd)) {
      all.push_back(of_run.mean() / from_.nominal_stroke);
    }
    return all;
  };
  std::vector<Seen> in_sight;
  in_sight.reserve(judgement_.runs.size());
  for (const std::size_t i : judgement_.runs) {
    in_sight.push_back(seen(i));
  }
  JudgedStructure judged{structure, means(in_sight), {}};
  if (to_beat != nullptr && !clearly_better(judged.seen, to_beat->seen)) {
    return judged;
  }
  std::vector<Seen> out_of_sight =
      unseen(structure == Structure::ordered ? "runs left out, ordered" : "runs left out");
  if (interrupted_) {
    return judged;
  }
  judged.unseen = means(out_of_sight);
  if (to_beat == nullptr || clearly_better(judged.unseen, to_beat->unseen)) {
    unseen_ = std::move(out_of_sight);
  }
  return judged;
}

/// Fits the structure that the options ask for, or the one with which the observer errs less.
void Fit::choose_structure() {
  if (options_.structure == Structure::ordered) {
    fit_order();
  }
  const Runs which = judgeable();
  if (interrupted_ || which.size() < least_judged_runs) {
    return;
  }
  judgement_.runs = which;
  const FitVariant& now = problem_->variant;
  const bool has_order = now.taper && (now.loop_order || now.memory == Memory::plain);
  judgement_.structures = {judge(has_order ? Structure::ordered : Structure::paper_000, nullptr)};
  if (interrupted_ || has_order || options_.structure != Structure::automatic) {
    return;
  }
  const FitVariant variant = problem_->variant;
  const ThreePhaseParams<double> from = from_.kinetics;
  const Deviations found = u_;
  const std::vector<Weights> weights = weights_;
  fit_order();
  if (!interrupted_) {
    judgement_.structures.push_back(judge(Structure::ordered, &judgement_.structures.front()));
  }
  if (interrupted_ || judgement_.chosen() != Structure::ordered) {
    from_.kinetics = from;
    with(variant);
    u_ = found;
    weights_ = weights;
    simpler_strain_sd_ = 0;
  }
}

/// The accuracy of the strain for the observer: what the fit has left; or with ends and order what
/// was left without them, because what they explain of these runs by their number alone they do not
/// explain of others; and, up to most_factor times as much, so much that in runs that a fit has not
/// seen the observer's errors are as great as it reports.
Fit::Honest Fit::honest_strain_sd(double fitted_sd) {
  const double least = std::max(fitted_sd, simpler_strain_sd_);
  Honest honest{least, std::numeric_limits<double>::quiet_NaN()};
  for (double factor = 1; !unseen_.empty() && !interrupted_; factor *= factor_step) {
    honest.strain_sd = std::min(factor, most_factor) * least;
    ObserverErrors sum;
    for (const ObserverErrors& of_run : errors(unseen_, honest.strain_sd)) {
      sum += of_run;
    }
    honest.share_within_2_sd = sum.share_within_2_sd();
    if (honest.share_within_2_sd >= aimed_within_2_sd || factor > most_factor) {
      break;
    }
    const std::string stage = "reported deviation";
    interrupted_ = !options_.proceed({stage, 0, 0, usual_share(stage, 0)});
  }
  return honest;
}

double mean_error(const std::vector<double>& errors) {
  return std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
}

Structure Judgement::chosen() const {
  const bool second =
      structures.size() == 2 && clearly_better(structures[1].unseen, structures[0].unseen);
  return structures.at(second ? 1 : 0).structure;
}

}  // namespace smaservo::identify
