#include "host-sim/papers/fits/driven_steps.hpp"

#include <fmt/format.h>
#include <limits>
#include <numeric>

#include "host-sim/identify/fit/fit.hpp"
#include "model/files/error.hpp"
#include "observer/kalman.hpp"

namespace smaservo::fits {
namespace {

/// Time constant of the load's filter, which is the observer's. Unfiltered noise of a load cell
/// would drive models without memory to the middle of their loops.
constexpr double load_filter_s = KalmanTuning<double>{}.stress_filter_s;
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

double ambient_of(const identify::Run& run, double otherwise_K) {
  return run.ambient_K.empty() ? otherwise_K
                               : std::accumulate(run.ambient_K.begin(), run.ambient_K.end(), 0.0) /
                                     static_cast<double>(run.ambient_K.size());
}

void require_motion(const identify::Run& run) {
  if (run.kind != identify::RunKind::joule && run.kind != identify::RunKind::bath) {
    throw files::UserError(fmt::format("{}: is a {} run; must be of Joule heating or of a bath",
                                       run.name, identify::name_of(run.kind)));
  }
}

}  // namespace

DrivenSteps every_row(const identify::Run& run, double ambient_K) {
  require_motion(run);
  DrivenSteps steps{run.kind == identify::RunKind::bath,
                    ambient_of(run, ambient_K),
                    {},
                    {},
                    {},
                    run.stress_Pa,
                    run.strain};
  if (steps.bath) {
    steps.temperature_K = run.temperature_K;
    return steps;
  }
  const std::size_t rows = run.time_s.size();
  for (std::size_t i = 0; i < rows; ++i) {
    const std::size_t before = i == 0 ? 0 : i - 1;
    steps.dt_s.push_back(i == 0 ? run.time_s[1] - run.time_s[0]
                                : run.time_s[i] - run.time_s[before]);
    steps.power_W.push_back(0.5 * (run.current_A[i] * run.voltage_V[i] +
                                   run.current_A[before] * run.voltage_V[before]));
    const double weight = steps.dt_s[i] / (steps.dt_s[i] + load_filter_s);
    steps.stress_Pa[i] =
        steps.stress_Pa[before] + weight * (run.stress_Pa[i] - steps.stress_Pa[before]);
  }
  return steps;
}

DrivenSteps thinned(const identify::Run& run) {
  require_motion(run);
  const identify::FitRun fit = identify::thin_run(run, identify::coarse_step_s);
  DrivenSteps steps{run.kind == identify::RunKind::bath,
                    ambient_of(run, room_K),
                    fit.dt_s,
                    fit.power_W,
                    fit.temperature_K,
                    fit.stress_Pa,
                    {}};
  steps.strain.assign(fit.stress_Pa.size(), nothing);
  for (std::size_t i = 0; i < fit.after.size(); ++i) {
    steps.strain[fit.after[i]] = fit.strain[i];
  }
  return steps;
}

}  // namespace smaservo::fits
