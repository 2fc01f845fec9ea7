#pragma once
// Operations on a servo that clients request, over SDO: each function is a whole operation and
// waits for the bus. All throw UserError, and Interrupted if the servo is to be switched off
// meanwhile.

#include <nlohmann/json.hpp>

#include "host-sim/can/bus/recorder.hpp"
#include "host-sim/can/remote.hpp"
#include "host-sim/page/servos/traffic/live_traffic.hpp"

namespace smaservo::page {

struct OperationsPlan {
  std::optional<std::uint32_t> key;  ///< key of an access level (2003h:2)
  /// Silence of the bridge after which a servo that a client has enabled ends its heat.
  float watch_s = 1;
  double timeout_s = 0.5;  ///< longest wait for a servo's answer
};

class Operations {
 public:
  Operations(SharedBus& bus, LiveTraffic& traffic, Control& control, const OperationsPlan& plan);

  /// A servo that is present and may be commanded. Throws if it has not been found, is gone, or
  /// shares its node-id with another device.
  Servo& servo(unsigned node);
  can::Remote remote(unsigned node);
  can::Remote remote(const Servo& servo) { return remote(servo.node); }

  /// Reads what the bridge has to know of a servo. False if the device is no servo.
  bool join(Servo& servo);
  /// Reads the new entries of the change log. Returns the rows of parameters that have changed.
  std::vector<std::size_t> read_changes(Servo& servo);
  /// Treats all present entries of the change log as known.
  void skip_changes(Servo& servo);
  std::vector<std::size_t> read_parameters(Servo& servo);
  std::vector<std::size_t> read_parameters(Servo& servo, const std::vector<std::size_t>& rows);

  void enable(Servo& servo, Control::Ticket ticket);
  /// Switches the current off and checks that; the servo's watch time-out is the usual one again.
  void disable(Servo& servo);
  /// Shortens the servo's watch time-out; it is left unchanged if the bridge's access level does
  /// not suffice.
  void shorten_watch(Servo& servo);
  /// Restores the servo's usual watch time-out.
  void put_back_watch(Servo& servo);
  void reset_faults(Servo& servo);
  void set_mode(Servo& servo, int mode);
  void set_target(Servo& servo, double value);

  struct NewValue {
    std::size_t row;
    std::string text;  ///< text as for text::value_bytes()
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
    nlohmann::json figures, gains;  ///< as PROTOCOL.md describes them
  };
  Step step(Servo& servo, Control::Ticket ticket, std::int32_t amplitude_um, double seconds);

 private:
  static void read_pdo(Servo& servo, can::Remote& remote);
  void set_position(Servo& servo, double value);

  SharedBus& bus_;
  LiveTraffic& traffic_;
  Control& control_;
  OperationsPlan plan_;
};

/// A recording that waits for its end or its trigger while the bus is used for other tasks.
class RunningRecording {
 public:
  RunningRecording(can::Remote remote, can::RecordingPlan plan, double patience_s);
  ~RunningRecording() = default;
  RunningRecording(const RunningRecording&) = delete;
  RunningRecording& operator=(const RunningRecording&) = delete;

  unsigned node() const { return remote_.node(); }
  can::RecorderStage look();
  can::RecorderStage stage() const { return stage_; }  ///< when it was last looked at
  can::Recording read() { return can::read_recording(remote_, plan_); }
  void stop() { remote_.set("recorder.command", "0"); }
  const can::RecordingPlan& plan() const { return plan_; }

 private:
  can::Remote remote_;
  can::RecordingPlan plan_;
  std::optional<can::RecorderWatch> watch_;
  can::RecorderStage stage_ = can::RecorderStage::filling;
};

}  // namespace smaservo::page
