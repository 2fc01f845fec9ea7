#pragma once

#include <vector>

#include "host-sim/identify/runs/run.hpp"

namespace smaservo::fits {

/// The inputs of a wire between the rows of a joule or bath run.
struct DrivenSteps {
  bool bath;
  double ambient_K;                   ///< that of the run, or the assumed one
  std::vector<double> dt_s, power_W;  ///< joule
  std::vector<double> temperature_K;  ///< bath
  std::vector<double> stress_Pa;
  std::vector<double> strain;  ///< strain at the end of each step; NaN if it is not compared
};

/// Every row of a run; `ambient_K` is used for runs without an ambient temperature. Throws
/// UserError for other kinds of runs.
DrivenSteps every_row(const identify::Run& run, double ambient_K = room_K);
/// The run thinned for a fit: steps of about 24 ms, with the mean power over each.
DrivenSteps thinned(const identify::Run& run);

}  // namespace smaservo::fits
