#pragma once
// The part of the servo node that is independent of the scalar type: objects beyond 1FFFh, the
// drive, faults, recorder, change log. servo.hpp connects it to a device.

#include "firmware/canopen/node/command_watch.hpp"
#include "firmware/canopen/node/node.hpp"
#include "firmware/canopen/servo/axis.hpp"
#include "firmware/canopen/servo/change_log.hpp"
#include "firmware/canopen/servo/parameter_access.hpp"
#include "firmware/canopen/servo/recorder.hpp"
#include "firmware/canopen/servo/step_test.hpp"

namespace smaservo::canopen {

inline constexpr std::uint32_t servo_device_type = 0x0002'0192;  ///< servo drive of CiA 402
inline constexpr std::uint32_t servo_product = 0x534D'4101;
inline constexpr std::uint32_t servo_revision = 0x0001'0000;

/// Keys of 2003h, one for each Level above `operate`. They prevent mistakes, not attacks: anyone
/// who reads the bus can see them. 0: no key is needed.
struct AccessKeys {
  std::uint32_t tune = 0, set_up = 0;
};

struct ServoConfig {
  NodeConfig node;  ///< identity, type and node-id are filled in by Servo
  Ceilings ceilings;
  AccessKeys keys;
  /// Heat may continue without a command source. If false, it ends when the time of 2002h:1 has
  /// passed since the last command, unless 1016h or the event timers of RPDOs watch the command
  /// source.
  bool unattended = false;
  std::span<float> recorder;  ///< memory of the recorder; may be empty
  float step_s = 1e-3F;       ///< period of the loop
};

/// Timing of the loop since its start.
struct LoopTiming {
  std::uint32_t steps, missed;
  float mean_late_s, max_late_s, mean_busy_s, max_busy_s;
};

/// The result of a step of the device.
struct StepReport {
  Signals signals;
  DeviceState state;
  FaultSet latched, active, warnings, blocks;
  Fault first_cause;
  std::uint32_t limit_reasons;
  WarningCount told_count;
  float dt_s;
};

class ServoCore : public Application {
 public:
  ServoCore(const ServoConfig& config, ParameterAccess& parameters)
      : config_(config),
        parameters_(parameters),
        node_(config.node, *this, sdo_buffer_),
        axis_(objects_),
        recorder_(objects_, config.recorder),
        step_test_(objects_) {}
  ServoCore(const ServoCore&) = delete;
  ServoCore& operator=(const ServoCore&) = delete;

  void advance(std::uint64_t now_us);
  void publish(const StepReport& report);
  void set_timing(const LoopTiming& timing);
  void set_bus(std::uint32_t dropped, std::uint32_t off, std::uint32_t queue_full) {
    objects_.bus = {dropped, off, queue_full};
  }
  /// Logs a change of a parameter that did not come over the bus.
  void note_change(Key key, std::uint32_t before, std::uint32_t value, Source source);

  AxisDemand demand() const { return axis_.demand(); }
  /// Whether the command source is present or not required.
  bool is_fresh() const;
  /// The faults that only the bus can detect, for Inputs::external.
  FaultSet external() const;
  /// Number of set-points written since the start in modes that follow them at once; repeated
  /// values count as well.
  std::uint32_t setpoints() const { return setpoints_; }

  Node& node() { return node_; }
  const Node& node() const { return node_; }
  const Axis& axis() const { return axis_; }
  const DriveObjects& objects() const { return objects_; }
  bool take_change(LoggedChange& change) { return log_.take(change); }

  // The members of Application.
  Abort find(Key key, Entry& entry) const override;
  Abort read(const Entry& entry, std::uint32_t offset, std::span<std::uint8_t> to) override;
  Abort write(const Entry& entry, std::span<const std::uint8_t> from, Source source) override;
  ObjectTable table() override;
  void started(std::uint8_t node_id) override;
  void nmt_changed(Nmt state) override;
  void connection_lost(std::uint16_t code) override;
  Abort may_request(Request request) const override;
  bool may_write(Level level) const override;
  void written(Key key, std::uint32_t old_value, std::uint32_t value, Source source,
               Abort result) override;

 protected:
  ~ServoCore() = default;
  void revert_tuning(Source source);
  /// Logs that a tuning transaction ends, if there is one.
  void log_revert(Source source);

 private:
  Abort write_object(const Entry& entry, std::uint32_t value, Source source);
  Abort write_parameter(const Entry& entry, std::uint32_t value, Source source);
  Abort check(Key key, std::uint32_t value) const;
  Abort run(Key key, std::uint32_t value);
  void unlock(std::uint32_t key);
  Abort tune(TuningCommand command);
  void watch_client();
  void watch_command_source();
  std::uint8_t errors() const;
  void show_load();
  void show_tuning();
  void show_faults(const StepReport& report);
  void log(Key key, std::uint32_t before, std::uint32_t value, Source source, Abort result);
  std::byte* memory();

  ServoConfig config_;
  ParameterAccess& parameters_;
  DriveObjects objects_{};
  std::array<std::uint8_t, 64> sdo_buffer_{};
  Node node_;
  Axis axis_;
  Recorder recorder_;
  StepTest step_test_;
  ChangeLog log_;
  CommandWatch command_watch_;
  Signals signals_{};
  FaultSet latched_;
  std::uint64_t now_us_ = 0, tuned_us_ = 0;
  bool left_alone_ = false;  ///< the trial needs no client
  std::uint32_t setpoints_ = 0;
  std::uint8_t errors_ = 0;   ///< bits of 1001h caused by the device's faults
  bool missed_ = false;       ///< the loss of the command source has been reported
  bool silent_ = false;       ///< its loss was reported, and it has not come back
  bool load_changes_ = true;  ///< an object that pdo_load depends on has been written
};

}  // namespace smaservo::canopen
