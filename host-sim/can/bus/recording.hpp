#pragma once
// Signals at the rate of the loop, from the device's recorder (2300h).

#include "host-sim/can/remote.hpp"

namespace smaservo::can {

struct RecordingPlan {
  std::vector<std::string> signals;  ///< names of firmware/signals.hpp, at most 8
  double seconds = 1;
  double before_s = 0;  ///< the part of `seconds` that lies before the trigger
  std::string trigger;  ///< "temperature_K>350", "current_A<0.1"; empty: starts at once
};

struct Recording {
  std::vector<std::string> signals;
  double period_s = 0;
  std::vector<std::vector<double>> rows;  ///< a column for each signal

  /// Throws UserError for a signal that was not recorded.
  std::vector<double> column(const std::string& signal) const;
};

/// Sets the recorder's signals, rate and trigger, and arms it. Throws UserError.
void arm_recorder(Remote& remote, const RecordingPlan& plan);

/// Waits until the recorder is full or has the rows of the requested time. Throws UserError when
/// the trigger has not come within `patience_s`.
void wait_for_recorder(Remote& remote, const RecordingPlan& plan, double patience_s);

/// Stops the recorder and reads what it has. Throws UserError.
Recording read_recording(Remote& remote, const RecordingPlan& plan);

/// As CSV with a header; times begin at 0.
std::string to_csv(const Recording& recording);
/// Reads a file that to_csv() has made. Throws UserError.
Recording load_recording(const std::string& path);

}  // namespace smaservo::can
