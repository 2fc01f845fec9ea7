#pragma once
// The device's recorder (2300h), which records signals at the rate of the loop.

#include "host-sim/can/bus/recording.hpp"
#include "host-sim/can/remote.hpp"

namespace smaservo::can {

struct RecordingPlan {
  std::vector<std::string> signals;  ///< at most 8 of firmware/signals.hpp, with or without "live."
  double seconds = 1;
  double before_s = 0;  ///< the part of `seconds` that lies before the trigger
  std::string trigger;  ///< "wire_temperature_K>350", "drive_current_A<0.1"; empty: recording
                        ///< starts at once
};

/// Sets the recorder's signals, rate and trigger, and arms it. Throws UserError.
void arm_recorder(Remote& remote, const RecordingPlan& plan);

/// Asks an armed recorder whether it is full or has the rows of the requested time.
class RecorderWatch {
 public:
  RecorderWatch(Remote& remote, const RecordingPlan& plan, double patience_s);

  /// Throws UserError and stops the recorder if the trigger has not come within `patience_s`.
  bool is_complete();

 private:
  Remote& remote_;
  double patience_s_;
  std::int64_t until_us_, after_us_, triggered_us_ = 0;
  double rows_;
};

/// Waits until the recorder is full or has the rows of the requested time. Throws UserError if the
/// trigger has not come within `patience_s`.
void wait_for_recorder(Remote& remote, const RecordingPlan& plan, double patience_s);

/// Stops the recorder and reads its rows. Throws UserError.
Recording read_recording(Remote& remote, const RecordingPlan& plan);

/// Throws NoResult if the recording, which is in `file`, ended early.
void require_complete(const Recording& recording, const RecordingPlan& plan,
                      const std::string& file);

}  // namespace smaservo::can
