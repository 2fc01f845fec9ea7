#pragma once
// The device's recorder (2300h), which records signals at the rate of the loop.

#include <functional>

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

enum class RecorderStage : std::uint8_t {
  filling,    ///< collects the rows before the trigger; a crossing of the level does not count yet
  waiting,    ///< for the trigger
  recording,  ///< has been triggered
  complete,   ///< is full, has the rows of the requested time, or was stopped
};

/// Asks a recorder that was armed what it does.
class RecorderWatch {
 public:
  RecorderWatch(Remote& remote, const RecordingPlan& plan, double patience_s);

  /// Throws UserError and stops the recorder if the trigger has not come within `patience_s` of the
  /// construction.
  RecorderStage look();

 private:
  Remote& remote_;
  double patience_s_;
  std::int64_t until_us_, after_us_, triggered_us_ = 0;
  double rows_, rows_before_;
  bool can_trigger_ = false;
};

/// Waits until the recorder is complete, and calls `waits`, at most once, when it waits for its
/// trigger. Throws UserError if the trigger has not come within `patience_s`.
void wait_for_recorder(
    Remote& remote, const RecordingPlan& plan, double patience_s,
    const std::function<void()>& waits = [] {});

/// Stops the recorder and reads its rows. Throws UserError.
Recording read_recording(Remote& remote, const RecordingPlan& plan);

/// Throws NoResult if the recording, which is in `file`, ended early.
void require_complete(const Recording& recording, const RecordingPlan& plan,
                      const std::string& file);

}  // namespace smaservo::can
