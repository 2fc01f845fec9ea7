#pragma once
// The drive of CiA 402: states, option codes, modes. It turns the master's objects into what the
// device is told, and what the device does into statusword and positions.
//
//   Not ready -> Switch on disabled -> Ready -> Switched on -> Operation enabled -> ...
//
// The device may be armed in Operation enabled; and, where an option code says so, in Quick stop
// active (605Ah = 6, holds) and Fault reaction active (605Eh = 2, safe.state). Nowhere else.

#include "firmware/canopen/servo/drive_objects.hpp"
#include "firmware/canopen/servo/parameter_access.hpp"
#include "firmware/command.hpp"

namespace smaservo::canopen {

enum class DriveState : std::uint8_t {
  not_ready,
  disabled,  ///< Switch on disabled
  ready,     ///< Ready to switch on
  on,        ///< Switched on
  enabled,   ///< Operation enabled
  quick_stop,
  reacting,  ///< Fault reaction active
  fault,
};

/// What the axis learns from a step of the device.
struct AxisFeedback {
  DeviceState device = DeviceState::starting;
  bool blocked = false;   ///< something active blocks arming
  bool supplied = false;  ///< the drive has its voltage
  bool warning = false;
  bool limited = false;    ///< by something else than the planner
  std::uint16_t code = 0;  ///< of the first cause of a fault, or what blocks
  float position_m = 0, velocity_m_s = 0, force_N = 0;
};

struct AxisDemand {
  bool arm = false;
  bool clear = false;
  Mode mode = Mode::off;
  float setpoint = 0;
};

class Axis {
 public:
  explicit Axis(DriveObjects& objects) : o_(objects) {}

  /// After a reset of the node: nothing is enabled, home is where axis.zero_strain says.
  void reset(bool has_force);
  /// Whether 6060h may be given this mode.
  Abort check_mode(std::int32_t mode) const;
  static Abort check_option(std::uint16_t index, std::int32_t value);
  /// 6040h has been written; a rising edge counts even when it falls before the next advance().
  void controlword(std::uint16_t before, std::uint16_t now);
  void feedback(const AxisFeedback& feedback);
  /// One transition at most, then the set-point moves on.
  void advance(std::uint64_t now_us);
  void connection_lost(std::uint16_t code);
  /// Ends the heat, since the node falls silent or starts anew.
  void stop();
  /// Whether controlwords are carried out.
  void remote(bool may_command) { remote_ = may_command; }
  /// Targets beyond it are limited, as by 607Dh.
  void set_reach(const Reach& reach) { reach_ = reach; }

  DriveState state() const { return state_; }
  AxisDemand demand() const;
  bool is_enabled() const { return state_ == DriveState::enabled; }
  /// The set-point that a cyclic mode follows has changed: it is reached after the time of 60C2h.
  void new_cyclic_setpoint();
  /// Whether, in the present mode, the object is a set-point that the axis follows at once.
  bool follows(Key key) const;
  /// Whether the device may be armed; as long as it may, some settings must not change.
  bool may_heat() const;
  /// The master has gone and 6007h makes a fault of it; true until the fault is reset.
  bool bus_lost() const { return bus_lost_; }
  /// In Profile position: goes there, as by a new set-point. For the step test.
  void go_to(std::int32_t position_um) { start_move(position_um); }
  std::int32_t moves_to() const { return active_um_; }
  /// The code of a fault that the axis has found itself, until it is reset; 0: there is none.
  std::uint16_t own_fault() const { return own_fault_ ? own_code_ : std::uint16_t{0}; }
  /// The code of a new fault that the axis has found itself, once; 0: there is none.
  std::uint16_t take_own_fault();

 private:
  void transition();
  void command();
  bool react_to_faults();
  void enter(DriveState next);
  void fail(std::uint16_t code);
  void watch_arming();
  void reset_fault();
  void set_mode();
  void new_setpoint(std::uint16_t word);
  void start_move(std::int32_t target_um);
  void stand_still();
  void move(float dt_s);
  void move_position(float dt_s);
  void home();
  void watch_position(float dt_s);
  void show();
  std::uint16_t mode_bits() const;
  std::int32_t limited(std::int32_t target_um);
  float interpolated(float from, float to, float dt_s) const;
  bool moves_position() const;
  bool halted() const { return (o_.controlword & 0x100U) != 0; }
  DriveMode mode() const { return static_cast<DriveMode>(o_.mode_display); }

  DriveObjects& o_;
  AxisFeedback in_{};
  Reach reach_{-1e3F, 1e3F};
  std::uint64_t now_us_ = 0;
  float ramp_um_ = 0;  ///< position set-point on its way to the target
  float held_ = 0;     ///< set-point of the modes -1 to -3; a halt does not change it
  float force_ = 0;    ///< set-point of modes 4 and 10, on its way, in 1/1000 of the rated force
  float to_setpoint_s_ = 0;  ///< until a cyclic mode's set-point is to be reached
  float missing_s_ = 0;      ///< following error beyond its window for so long
  float within_s_ = 0;       ///< in the position window for so long
  std::int32_t active_um_ = 0, waiting_um_ = 0;
  std::int32_t shift_um_ = 0;  ///< home: shown position less the device's
  std::uint16_t own_code_ = 0;
  std::uint8_t clear_steps_ = 0;
  std::uint8_t refused_ = 0;  ///< steps in which the device did not arm
  DriveState state_ = DriveState::not_ready;
  bool has_force_ = false;
  bool remote_ = false;
  bool reset_edge_ = false;
  bool bus_lost_ = false;
  bool own_fault_ = false, own_fault_new_ = false;
  bool heated_ = false;  ///< the device has armed since Operation enabled
  bool halted_before_ = false;
  bool moving_ = false;
  bool waits_ = false;  ///< a set-point waits for the one before
  bool acknowledged_ = false;
  bool reached_ = false;
  bool beyond_ = false;  ///< the last target was beyond what it may be
  bool homed_ = false;
  bool following_ = false;  ///< the following error is beyond its window
};

}  // namespace smaservo::canopen
