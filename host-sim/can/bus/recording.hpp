#pragma once
// Signals at the rate of the loop, from the device's recorder (2300h).

#include "host-sim/can/remote.hpp"

namespace smaservo::can {

struct RecordingPlan {
  std::vector<std::string> signals;  ///< names of firmware/signals.hpp, at most 8
  double seconds = 1;
  double before_s = 0;  ///< of that, before the trigger
  std::string trigger;  ///< "temperature_K>350", "current_A<0.1"; empty: at once
};

struct Recording {
  std::vector<std::string> signals;
  double period_s = 0;
  std::vector<std::vector<double>> rows;  ///< a column for each signal

  /// Throws UserError where it was not recorded.
  std::vector<double> column(const std::string& signal) const;
};

/// Chooses signals, rate and trigger, and arms. Throws UserError.
void arm_recorder(Remote& remote, const RecordingPlan& plan);

/// Waits until it is full, or has gone on for so long after the trigger. Throws UserError where the
/// trigger has not come in time.
void wait_for_recorder(Remote& remote, const RecordingPlan& plan, double patience_s);

/// Stops the recorder and reads what it has. Throws UserError.
Recording read_recording(Remote& remote, const RecordingPlan& plan);

/// With a header; times from 0 on.
std::string to_csv(const Recording& recording);
/// Such a file. Throws UserError.
Recording load_recording(const std::string& path);

}  // namespace smaservo::can
