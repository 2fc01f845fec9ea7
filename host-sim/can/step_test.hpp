#pragma once
// A step to a target and back, made by the device (2400h), judged and drawn.

#include "host-sim/can/bus/recorder.hpp"
#include "host-sim/report/step_figures.hpp"

namespace smaservo::can {

struct StepPlan {
  std::int32_t amplitude_um = 500;
  double seconds = 2;  ///< duration of each of the two steps
};

struct StepRun {
  StepPlan plan;
  Recording recording;  ///< setpoint, position_m, wire_temperature_K, drive_current_A
};

/// Runs the test; enables a disabled drive for its duration. Throws UserError.
StepRun run_step(Remote& remote, const StepPlan& plan);

struct StepResult {
  report::StepFigures figures;  ///< percentages relate to the amplitude
  double peak_K;
};
/// Judges the first of the two steps. Throws UserError if the recording contains none.
StepResult judge(const StepRun& run);

/// Reads a run from its CSV file; the plan is derived from the set-points. Throws UserError.
StepRun load_step(const std::string& path);

/// A table of the runs' figures, the newest first, and a plot that overlays them.
std::string step_text(const std::vector<StepRun>& runs, const std::vector<std::string>& names);

/// Like step_text(), as a page with pictures. Needs gnuplot. Throws UserError.
void write_step_report(const std::string& path, const std::vector<StepRun>& runs,
                       const std::vector<std::string>& names);

}  // namespace smaservo::can
