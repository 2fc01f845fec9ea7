#pragma once
// The drive of CiA 402: states, option codes, modes. It converts the master's objects to demands on
// the device, and the device's feedback to statusword and positions.
//
//   Not ready -> Switch on disabled -> Ready -> Switched on -> Operation enabled -> ...
//
// The device may be armed in Operation enabled; if the option codes say so, also in Quick stop
// active (605Ah = 6, hold) and Fault reaction active (605Eh = 2, safe.state). In no other state.

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

/// The result of a device's step, as far as the axis needs it.
struct AxisFeedback {
  DeviceState device = DeviceState::starting;
  bool blocked = false;   ///< an active condition blocks arming
  bool supplied = false;  ///< the drive has its supply voltage
  bool warning = false;
  bool limited = false;  ///< limited by something other than the trajectory planner
  /// Error code of the first cause; without one, of the first condition that blocks arming.
  std::uint16_t code = 0;
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

  /// To be called after a reset of the node: nothing is enabled, the home position is that of
  /// axis.zero_strain.
  void reset(bool has_force);
  /// Whether 6060h may be set to this mode.
  Abort check_mode(std::int32_t mode) const;
  static Abort check_option(std::uint16_t index, std::int32_t value);
  /// To be called when 6040h has been written; a rising edge counts even if the bit falls again
  /// before the next advance().
  void controlword(std::uint16_t before, std::uint16_t now);
  void feedback(const AxisFeedback& feedback);
  /// Makes at most one transition, then moves the set-point on.
  void advance(std::uint64_t now_us);
  void connection_lost(std::uint16_t code);
  /// Ends the heat, because the node becomes silent or restarts.
  void stop();
  /// Sets whether controlwords are carried out.
  void remote(bool may_command) { remote_ = may_command; }
  /// Sets the reach; targets beyond it are clamped, as by 607Dh.
  void set_reach(const Reach& reach) { reach_ = reach; }

  DriveState state() const { return state_; }
  AxisDemand demand() const;
  bool is_enabled() const { return state_ == DriveState::enabled; }
  /// To be called when the set-point of a cyclic mode has changed: it is reached after the period
  /// of 60C2h.
  void new_cyclic_setpoint();
  /// Whether the object is a set-point that the axis follows at once in the present mode.
  bool follows(Key key) const;
  /// Whether the device may be armed; while this is true, some settings must not change.
  bool may_heat() const;
  /// Whether the master was lost and 6007h makes a fault of that; true until the fault is reset.
  bool bus_lost() const { return bus_lost_; }
  /// Moves to the position as by a new set-point of mode Profile position. For the step test.
  void go_to(std::int32_t position_um) { start_move(position_um); }
  std::int32_t moves_to() const { return active_um_; }
  /// The code of a fault that the axis itself has raised, until it is reset; 0: none.
  std::uint16_t own_fault() const { return own_fault_ ? own_code_ : std::uint16_t{0}; }
  /// The code of a new fault that the axis itself has raised, given once; 0: none.
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
  float ramp_um_ = 0;  ///< position set-point, moving towards the target
  float held_ = 0;     ///< set-point of the modes -1 to -3; a halt does not change it
  /// Set-point of the modes 4 and 10, moving to the target, in 1/1000 of the rated force.
  float force_ = 0;
  float to_setpoint_s_ = 0;  ///< time left until a cyclic mode's set-point is to be reached
  float missing_s_ = 0;      ///< time for which the following error has been beyond its window
  float within_s_ = 0;       ///< time for which the position has been in the window
  std::int32_t active_um_ = 0, waiting_um_ = 0;
  std::int32_t shift_um_ = 0;  ///< home: shown position less the device's position
  std::uint16_t own_code_ = 0;
  std::uint8_t clear_steps_ = 0;
  std::uint8_t refused_ = 0;  ///< steps for which the device has not armed
  DriveState state_ = DriveState::not_ready;
  bool has_force_ = false;
  bool remote_ = false;
  bool reset_edge_ = false;
  bool bus_lost_ = false;
  bool own_fault_ = false, own_fault_new_ = false;
  bool heated_ = false;  ///< the device has been armed since Operation enabled
  bool halted_before_ = false;
  bool moving_ = false;
  bool waits_ = false;  ///< a set-point waits until the one before is reached
  bool acknowledged_ = false;
  bool reached_ = false;
  bool beyond_ = false;  ///< the last target had to be clamped
  bool homed_ = false;
  bool following_ = false;  ///< the following error is beyond its window
};

}  // namespace smaservo::canopen
