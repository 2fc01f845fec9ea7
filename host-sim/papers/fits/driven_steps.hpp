#pragma once

#include <vector>

#include "host-sim/identify/runs/run.hpp"

namespace smaservo::fits {

/// The inputs of a wire from row to row of a joule or bath run.
struct DrivenSteps {
  bool bath;
  double ambient_K;                   ///< the run's own, or the assumed one
  std::vector<double> dt_s, power_W;  ///< joule
  std::vector<double> temperature_K;  ///< bath
  std::vector<double> stress_Pa;
  std::vector<double> strain;  ///< at the end of each step; NaN where it does not count
};

/// Every row of a run; `ambient_K` is for runs without an ambient temperature. Throws UserError for
/// other kinds of runs.
DrivenSteps every_row(const identify::Run& run, double ambient_K = room_K);
/// Thinned for a fit: steps of about 24 ms, the power's mean over each.
DrivenSteps thinned(const identify::Run& run);

}  // namespace smaservo::fits
