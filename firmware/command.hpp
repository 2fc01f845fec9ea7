#pragma once
// What goes into one step of the device, and what comes out of it.

#include <cstdint>

#include "firmware/faults.hpp"
#include "observer/measurement.hpp"

namespace smaservo {

/// The controlled variable. A set-point is in SI units of its mode.
enum class Mode : std::uint8_t {
  off,             ///< no current
  current,         ///< A
  power,           ///< W, into the wire
  resistance,      ///< ohm
  temperature,     ///< K, of the wire's middle, as estimated
  strain,          ///< elongation of the whole wire
  position,        ///< m of contraction from PositionSettings::zero_strain
  force,           ///< N, by the load cell
  identification,  ///< the built-in profile; the set-point has no meaning
};
inline constexpr std::uint8_t mode_count = 9;

/// Factors by which a command scales the gains of its mode's loop.
template <class S>
struct GainScale {
  S proportional = S(1), integral = S(1), derivative = S(1);
};

/// What a device is told in a step.
template <class S>
struct Command {
  bool fresh = false;  ///< received since the last step: the command source is alive
  bool arm = false;    ///< request to run; a falling edge disarms
  bool clear_faults = false;
  Mode mode = Mode::off;
  S setpoint = S(0);
  GainScale<S> scale{};
};

/// All readings of one instant. What a board cannot read is NaN; what it cannot tell is false.
template <class S>
struct Inputs {
  bool fresh = false;  ///< a new frame; otherwise the readings mean nothing
  std::uint32_t sequence = 0;
  Sample<S> sample{};
  S supply_V;
  S ambient_K;  ///< of the air, where there is a sensor
  S driver_K;   ///< of the output stage
  bool emergency_stop = false;
  bool driver_fault = false;
  bool deadline_missed = false;  ///< the caller was late for this step
  FaultSet external;  ///< faults that only the caller can know: bus, boot, store, settings
};

enum class DeviceState : std::uint8_t {
  starting,  ///< reads the zero-current offset and finds out where the wire is
  ready,     ///< no current
  arming,    ///< a sense current checks the wire
  running,
  stopping,  ///< the safe state after a fault: holds or releases
  fault,     ///< no current until the faults are cleared
};
inline constexpr std::uint8_t device_state_count = 6;

/// States in which a current may be given.
constexpr bool is_heated(DeviceState state) {
  return state == DeviceState::arming || state == DeviceState::running ||
         state == DeviceState::stopping;
}

/// Why the output is less, or more, than the loop wants.
enum class LimitReason : std::uint8_t {
  min_current,
  current,
  power,
  temperature,
  strain,
  stress,
  duty,
  supply,      ///< the converter has no more voltage
  trajectory,  ///< the planner waits for the wire
  protection,  ///< a fault of class L is active, or was within the last second
  count
};

/// A step's result: what the drive is to do, and why.
template <class S>
struct Output {
  // To the drive. Zero unless heat is allowed.
  S drive_current_A;
  S drive_voltage_V;  ///< for a drive of DriveKind::voltage
  // What the current was computed from.
  DeviceState state;
  Mode mode;         ///< in force; off where no current is allowed
  S setpoint;        ///< in force, after limits
  S reference;       ///< of the trajectory, in the set-point's unit
  S wanted_power_W;  ///< that the controller asks for, after limits
  Measurement<S> measurement;
  Estimate<S> estimate;
  S estimated_ambient_K;        ///< by the observer
  S hot_spot_K;                 ///< highest temperature to be expected anywhere along the wire
  std::uint32_t limit_reasons;  ///< bit 1 << LimitReason
  FaultSet active;              ///< conditions present now, after their deglitch time
  FaultSet latched;             ///< faults that have not been cleared
  Fault first_cause;            ///< the fault that was latched first; Fault::none without one
  FaultSet warnings;            ///< each stands for at least a second after its cause
  /// Of each warning in turn, one in each step. So a reader that has missed steps has all counts
  /// again after warning_count steps, and an output is copied without all of them.
  WarningCount told_count;
  FaultSet blocks;        ///< all reasons why the device cannot be armed; empty while it is armed
  std::uint64_t time_us;  ///< of the loop: the sum of all dt_s since start()
  std::uint64_t first_cause_us;  ///< time of the first cause
  S cooling;         ///< as a share of the wire file's, by the last test; 1 where it is not weaker
  S wire_stress_Pa;  ///< by the observer: of the load and, at axis.stop_strain, of the stop
  /// The wire pulls at its stop, and the observer is sure of it: control and protection take
  /// wire_stress_Pa for the measured stress.
  bool at_stop;

  /// The stress that control and protection see.
  constexpr S stress_Pa() const { return at_stop ? wire_stress_Pa : measurement.stress_Pa; }
  /// Whether this reason holds the output.
  constexpr bool limited_by(LimitReason reason) const {
    return (limit_reasons >> static_cast<unsigned>(reason) & 1U) != 0;
  }
};

}  // namespace smaservo
