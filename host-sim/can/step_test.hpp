#pragma once
// A step there and back on the device (2400h), judged and drawn.

#include "host-sim/can/bus/recorder.hpp"
#include "host-sim/report/step_figures.hpp"

namespace smaservo::can {

struct StepPlan {
  std::int32_t amplitude_um = 500;
  double seconds = 2;  ///< of each of the two steps
};

struct StepRun {
  StepPlan plan;
  Recording recording;  ///< setpoint, position_m, wire_temperature_K, drive_current_A
};

/// Enables a disabled drive for the time of the test. Throws UserError.
StepRun run_step(Remote& remote, const StepPlan& plan);

struct StepResult {
  report::StepFigures figures;  ///< percentages are of the amplitude
  double peak_K;
};
/// Judges the first of the two steps. Throws UserError when the recording has none.
StepResult judge(const StepRun& run);

/// Reads a run from its CSV file; the plan follows from the set-points. Throws UserError.
StepRun load_step(const std::string& path);

/// A table of the runs' figures, the newest first, and a plot that overlays them.
std::string step_text(const std::vector<StepRun>& runs, const std::vector<std::string>& names);

/// The same as a page with pictures. Needs gnuplot. Throws UserError.
void write_step_report(const std::string& path, const std::vector<StepRun>& runs,
                       const std::vector<std::string>& names);

}  // namespace smaservo::can
