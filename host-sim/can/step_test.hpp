#pragma once
// A step to a target and back, made by the device (2400h), judged and drawn.

#include <map>
#include <string_view>

#include "host-sim/can/bus/recorder.hpp"
#include "host-sim/report/step_figures.hpp"
#include "host-sim/units.hpp"

namespace smaservo::can {

struct StepPlan {
  std::int32_t amplitude_um = 500;
  double seconds = 2;  ///< duration of each of the two steps
};

struct StepRun {
  StepPlan plan;
  Recording recording;  ///< setpoint, position_m, wire_temperature_K, drive_current_A
  /// The parameters in force that shape a step, by their paths, and their values in SI; empty: not
  /// recorded.
  std::map<std::string, std::string> gains = {};  // NOLINT(readability-redundant-member-init)
};

/// Whether a parameter of this path shapes the response to a step: the strain loop, the trajectory,
/// the drive, the limits.
bool shapes_step(std::string_view path);
/// The parameters that shape a step, as they are in force. Throws UserError.
std::map<std::string, std::string> read_gains(Remote& remote);

/// Runs the test; enables a disabled drive for its duration. Throws UserError.
StepRun run_step(Remote& remote, const StepPlan& plan);

struct StepResult {
  report::StepFigures figures;  ///< percentages relate to the amplitude
  double peak_K;
};
/// Judges the first of the two steps. Throws UserError if the recording contains none.
StepResult judge(const StepRun& run);

/// The run as a CSV file, with its gains as comments.
std::string step_csv(const StepRun& run);
/// Reads a run from its CSV file; the plan is derived from the set-points. Throws UserError.
StepRun load_step(const std::string& path);

/// A table of the runs' figures, the newest first, a plot that overlays them, and their gains:
/// those that differ between the runs for each run, the others once. All in the chosen units.
std::string step_text(const std::vector<StepRun>& runs, const std::vector<std::string>& names,
                      Units units);

/// Like step_text(), as a page with pictures. Needs gnuplot. Throws UserError.
void write_step_report(const std::string& path, const std::vector<StepRun>& runs,
                       const std::vector<std::string>& names, Units units);

}  // namespace smaservo::can
