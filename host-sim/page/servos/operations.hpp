#pragma once
// What clients ask of a servo, over SDO: each function is a whole operation, which waits for the
// bus. All throw UserError, and Interrupted when the servo is to be switched off meanwhile.

#include <nlohmann/json.hpp>

#include "host-sim/can/bus/recorder.hpp"
#include "host-sim/can/remote.hpp"
#include "host-sim/page/servos/traffic/live_traffic.hpp"

namespace smaservo::page {

struct OperationsPlan {
  std::optional<std::uint32_t> key;  ///< of an access level (2003h:2)
  /// The longest silence of the bridge after which a servo that a client has enabled ends its heat.
  float watch_s = 1;
  double timeout_s = 0.5;  ///< longest wait for a servo's answer
};

class Operations {
 public:
  Operations(SharedBus& bus, LiveTraffic& traffic, Control& control, const OperationsPlan& plan);

  /// A servo that is there and may be commanded. Throws where it has not been found, is gone, or is
  /// one of two with its node-id.
  Servo& servo(unsigned node);
  can::Remote remote(unsigned node);
  can::Remote remote(const Servo& servo) { return remote(servo.node); }

  /// Reads what the bridge must know of a servo. False: the device is none.
  bool join(Servo& servo);
  /// Reads the change log after it has grown. Returns the rows of parameters that have changed.
  std::vector<std::size_t> read_changes(Servo& servo);
  /// What the change log has now is known.
  void skip_changes(Servo& servo);
  std::vector<std::size_t> read_parameters(Servo& servo);
  std::vector<std::size_t> read_parameters(Servo& servo, const std::vector<std::size_t>& rows);

  void enable(Servo& servo, Control::Ticket ticket);
  /// Current off, checked; the watch of the servo is what it was.
  void disable(Servo& servo);
  /// The watch of the servo is what it was.
  void put_back_watch(Servo& servo);
  void reset_faults(Servo& servo);
  void set_mode(Servo& servo, int mode);
  void set_target(Servo& servo, double value);

  struct NewValue {
    std::size_t row;
    std::string text;  ///< as text::value_bytes() takes it
  };
  void write(Servo& servo, const std::vector<NewValue>& values);
  void try_for(Servo& servo, const std::vector<NewValue>& values, double seconds);
  void commit(Servo& servo);
  void revert(Servo& servo);
  void store(Servo& servo);

  std::string dump(Servo& servo, const std::string& as);
  nlohmann::json diff(Servo& servo, const std::string& toml);
  nlohmann::json restore(Servo& servo, const std::string& toml);
  struct Step {
    can::Recording recording;
    nlohmann::json figures, gains;  ///< as PROTOCOL.md has them
  };
  Step step(Servo& servo, Control::Ticket ticket, std::int32_t amplitude_um, double seconds);

 private:
  void shorten_watch(Servo& servo, can::Remote& remote);
  static void read_pdo(Servo& servo, can::Remote& remote);
  void set_position(Servo& servo, double value);

  SharedBus& bus_;
  LiveTraffic& traffic_;
  Control& control_;
  OperationsPlan plan_;
};

/// A recording that waits for its end or its trigger, while the bus goes on.
class RunningRecording {
 public:
  RunningRecording(can::Remote remote, can::RecordingPlan plan, double patience_s);
  ~RunningRecording() = default;
  RunningRecording(const RunningRecording&) = delete;
  RunningRecording& operator=(const RunningRecording&) = delete;

  unsigned node() { return remote_.node(); }
  // NOLINTNEXTLINE(bugprone-unchecked-optional-access): made with the recording
  bool is_complete() { return watch_->is_complete(); }
  can::Recording read() { return can::read_recording(remote_, plan_); }
  void stop() { remote_.set("recorder.command", "0"); }
  const can::RecordingPlan& plan() const { return plan_; }

 private:
  can::Remote remote_;
  can::RecordingPlan plan_;
  std::optional<can::RecorderWatch> watch_;
};

}  // namespace smaservo::page
