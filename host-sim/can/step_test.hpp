#pragma once
// A step there and back on the device (2400h), judged and drawn.

#include "host-sim/can/bus/recording.hpp"
#include "host-sim/report/step_figures.hpp"

namespace smaservo::can {

struct StepPlan {
  std::int32_t amplitude_um = 500;
  double seconds = 2;  ///< there, and as long back
};

struct StepRun {
  StepPlan plan;
  Recording recording;  ///< setpoint, position_m, temperature_K, current_A
};

/// Enables the drive where it is not, and disables it then again. Throws UserError.
StepRun run_step(Remote& remote, const StepPlan& plan);

struct StepResult {
  report::StepFigures figures;  ///< percentages are of the amplitude
  double peak_K;
};
/// Of the step there. Throws UserError where the recording has none.
StepResult judge(const StepRun& run);

/// A run as a file, and back; the plan follows from its set-points. Throws UserError.
StepRun load_step(const std::string& path);

/// Figures of the runs, the newest first, one line each, and a plot of all over each other.
std::string step_text(const std::vector<StepRun>& runs, const std::vector<std::string>& names);

/// The same as a page with pictures, runs over each other. Needs gnuplot. Throws UserError.
void write_step_report(const std::string& path, const std::vector<StepRun>& runs,
                       const std::vector<std::string>& names);

}  // namespace smaservo::can
