// How a fitted wire predicts runs that the fit has not seen.

#include <algorithm>
#include <iterator>

#include "host-sim/identify/fit/fit_state.hpp"

namespace smaservo::identify {
namespace {

Run first_rows(Run run, std::size_t rows) {
  for (std::vector<double>* const column :
       {&run.time_s, &run.current_A, &run.voltage_V, &run.stress_Pa, &run.strain,
        &run.resistance_ohm, &run.temperature_K, &run.ambient_K, &run.power_W_kg, &run.heating_W}) {
    column->resize(std::min(column->size(), rows));
  }
  run.lines.resize(std::min(run.lines.size(), rows));
  return run;
}

}  // namespace

std::vector<FittedRun> held_out(const FitResult& fit, const std::vector<Run>& runs,
                                const FitOptions& options) {
  std::vector<Run> beginnings;
  std::ranges::transform(runs, std::back_inserter(beginnings), [](const Run& run) {
    const auto rows = static_cast<double>(run.lines.size());
    return first_rows(run, static_cast<std::size_t>(held_out_known_share * rows));
  });
  return runs.empty() ? std::vector<FittedRun>()
                      : Fit(fit.wire, runs, options)
                            .predicted(Fit(fit.wire, beginnings, options).known_circumstances());
}

/// What belongs to each run alone, with the wire as it is.
Deviations Fit::known_circumstances() {
  // The wire is known, so each run has a zero of its own from the start: with one for all a run
  // ended in a minimum of another zero and another air.
  for (const std::size_t i : imposed_runs()) {
    find_zero({i});
  }
  const auto none = [](const std::string& /*key*/) { return false; };
  solve("runs held out", everything(), none, options_.max_iterations);
  refine();
  solve("runs held out", everything(), none, options_.max_iterations);
  return u_;
}

/// The errors of the rows behind those that told the circumstances.
std::vector<FittedRun> Fit::predicted(const Deviations& known) {
  u_ = known;
  refine();
  std::vector<FittedRun> all;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const std::size_t first = runs_[i].after.size();
    all.push_back(
        judged(i, static_cast<std::size_t>(held_out_known_share * static_cast<double>(first))));
  }
  return all;
}

}  // namespace smaservo::identify
