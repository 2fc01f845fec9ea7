#pragma once
// Everything that a user can set on a device. parameters.hpp describes each number once: path,
// unit, range, default, when it may change. Values are such as a float can hold, so that the store,
// CAN and a file configure the same device.

#include <cstdint>

#include "model/wire/wire.hpp"

namespace smaservo {

/// Which device this is on its bus.
struct Identity {
  std::uint32_t serial_number;
  std::uint32_t node_id;
};

/// The period of the loop, and how long it waits.
template <class S>
struct Timing {
  S period_s;           ///< nominal, of the loop
  S command_timeout_s;  ///< time without a fresh command that makes the fault command_timeout
  S sample_timeout_s;   ///< time without a fresh sample that makes the fault sample_stale
};

/// From raw readings to the wire's voltage, current and load.
template <class S>
struct MeasurementSettings {
  S current_offset_A;  ///< read at zero current, subtracted
  S voltage_offset_V;
  S load_offset_N;
  S load_gain;
  S current_noise_A;  ///< standard deviations
  S voltage_noise_V;
  S lead_resistance_ohm;  ///< 0 with four wires
  S constant_load_N;      ///< used where there is no load cell
  bool has_load_cell;
  S current_full_scale_A;  ///< a reading at or beyond it is saturated
  S voltage_full_scale_V;
};

/// What the observer starts from.
template <class S>
struct ObserverSettings {
  S start_ambient_sd_K;  ///< standard deviation of the air's temperature as first assumed
  /// Standard deviation of the heat loss, relative to the wire file's. A device is set up for its
  /// own surroundings: its default is 0.3. A replay, which knows nothing of those of a recording,
  /// starts from 1.5 (KalmanTuning).
  S start_loss_sd;
};

/// What the output stage takes.
enum class DriveKind : std::uint8_t {
  current,  ///< a current sink or current-mode converter
  voltage,  ///< a chopper: voltage over supply is the duty cycle
};

/// The output stage and its current loop.
template <class S>
struct DriveSettings {
  DriveKind kind;
  S proportional;  ///< gain of the current loop: A per A that are missing; with a voltage drive V
                   ///< per V of missing I R
  S integral_1_s;
  S min_supply_V, max_supply_V;
};

/// One loop from a controlled variable to heating power, in W by the variable's unit.
template <class S>
struct LoopGains {
  S proportional;
  S integral_1_s;         ///< integral gain by proportional gain: 1/T_i
  S derivative_s;         ///< derivative gain by proportional gain: T_d
  S derivative_filter_s;  ///< time constant of the filter on the measured variable
  S setpoint_weight;      ///< weight of the set-point in the proportional part, 0..1
  S derivative_weight;    ///< weight of the set-point in the derivative part, 0..1
  S tracking_s;           ///< time constant of the anti-windup by back-calculation
  S cooling_factor;       ///< factor on P and I gain where less heat is asked for
  S dead_band;            ///< to either side of the reference; inside, the temperature is held
};

/// How fast a set-point is approached.
template <class S>
struct TrajectorySettings {
  S heating_rate_1_s;  ///< greatest strain rate that the planner asks for while contracting
  S cooling_rate_1_s;  ///< the same while stretching; a wire that cools more slowly is waited for
  S lead_s;  ///< time by which a streaming set-point is led: the wire responds to heat with a delay
};

/// Limits that shape the output; none of them is a fault.
template <class S>
struct SoftLimits {
  S min_current_A;  ///< while running: keeps the resistance measurable
  S current_A;
  S power_W;
  S temperature_K;  ///< of the hottest spot
  S hot_spot_K;     ///< how far the hottest spot may lie above the estimated temperature
  S min_strain;     ///< strain of the shortest wire that is asked for
  S max_strain;
  S stress_Pa;
  S loss_margin;  ///< greatest cooling that is believed at the temperature limit, relative to the
                  ///< wire file's; it bounds the power that the wire gets for long
  S duty;         ///< greatest mean over duty_window_s of the square of current by current_A
  S duty_window_s;
};

/// Limits whose crossing is a fault.
template <class S>
struct TripLimits {
  S current_A;
  S temperature_K;  ///< of the hottest spot
  S stress_Pa;
  S slack_Pa;  ///< smallest stress; below it the load is lost
  S min_strain, max_strain;
  S following_error;  ///< greatest deviation of the strain from its reference, for following_s
  S following_s;
  S heating_rate_K_s;
  S resistance_low, resistance_high;  ///< of the cold wire, as a share of what its file says
  S current_offset_A;                 ///< greatest zero-current reading at arming
  S min_ambient_K, max_ambient_K;
  S driver_K;            ///< temperature of the output stage
  S drift;               ///< relative change of the resistance, a sign of fatigue
  std::uint32_t cycles;  ///< full cycles before a warning
};

enum class SafeState : std::uint8_t {
  off,
  hold,     ///< holds strain for hold_s, then off
  release,  ///< cools at release_1_s, then off
};

/// Which safe state follows a fault, and how.
template <class S>
struct SafeSettings {
  SafeState state;
  S hold_s;
  S release_1_s;  ///< strain rate
};

/// The heating profile for `host-sim identify`: full cycles, then inner loops that shrink.
template <class S>
struct ProfileSettings {
  S overheat_K;  ///< level 1 heats to so far above the finish of the transformation
  S cycle_s;     ///< duration of a full cycle
  S loop_s;      ///< duration of an inner loop
};

/// The axis of positions.
template <class S>
struct PositionSettings {
  S zero_strain;  ///< strain at position 0; positions count contraction
  /// Strain below which a hard stop keeps the wire from contracting; 0: there is none. Used where
  /// there is no load cell.
  S stop_strain;
};

/// All settings of a device.
template <class S>
struct Settings {
  Identity identity;
  Timing<S> timing;
  Wire<S> wire;
  MeasurementSettings<S> measurement;
  ObserverSettings<S> observer;
  DriveSettings<S> drive;
  LoopGains<S> strain, temperature, resistance, force;
  S feed_forward_s;  ///< time in which the feed-forward brings the wire to its reference; 0: it
                     ///< only replaces the heat lost
  S transfer_s;      ///< time constant in which a new mode or gain takes over
  TrajectorySettings<S> trajectory;
  SoftLimits<S> limits;
  TripLimits<S> trips;
  SafeSettings<S> safe;
  ProfileSettings<S> profile;
  PositionSettings<S> axis;
};

}  // namespace smaservo
