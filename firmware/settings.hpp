#pragma once
// Everything that a user can set on a device. parameters.hpp describes each number once: path,
// unit, range, default, when it may change. Values are those of a float, so that the store, CAN and
// a file give the same device.

#include <cstdint>

#include "model/wire/wire.hpp"

namespace smaservo {

struct Identity {
  std::uint32_t serial_number;
  std::uint32_t node_id;
};

template <class S>
struct Timing {
  S period_s;           ///< nominal, of the loop
  S command_timeout_s;  ///< without a fresh command for so long: command time-out
  S sample_timeout_s;   ///< without a fresh sample for so long: stale
};

/// From raw readings to the wire's voltage, current and load.
template <class S>
struct Measuring {
  S current_offset_A;  ///< read at zero current, subtracted
  S voltage_offset_V;
  S load_offset_N;
  S load_gain;
  S current_noise_A;  ///< standard deviations
  S voltage_noise_V;
  S lead_resistance_ohm;  ///< 0 with four wires
  S constant_load_N;      ///< taken where there is no load cell
  bool has_load_cell;
  S current_full_scale_A;  ///< a reading at or beyond it is saturated
  S voltage_full_scale_V;
};

/// What the observer starts from.
template <class S>
struct ObserverSettings {
  S ambient_sd_K;  ///< how well the air's temperature is known: standard deviation
  S loss_sd;       ///< and the cooling, relative to the wire's file
};

/// What the output stage takes.
enum class DriveKind : std::uint8_t {
  current,  ///< a current sink or current-mode converter
  voltage,  ///< a chopper: voltage over supply is the duty cycle
};

template <class S>
struct DriveSettings {
  DriveKind kind;
  S proportional;  ///< of the current loop: volts by volts of the missing I R; current by current
  S integral_1_s;
  S min_supply_V, max_supply_V;
};

/// One loop from a controlled variable to heating power, in W by the variable's unit.
template <class S>
struct LoopGains {
  S proportional;
  S integral_1_s;         ///< of the proportional gain: 1/T_i
  S derivative_s;         ///< of the proportional gain: T_d
  S derivative_filter_s;  ///< on the measured variable
  S setpoint_weight;      ///< of the proportional part, 0..1
  S derivative_weight;    ///< of the set-point in the derivative part, 0..1
  S tracking_s;           ///< anti-windup by back-calculation
  S cooling_factor;       ///< on the gains, where less heat is asked for
  S dead_band;            ///< of the controlled variable; inside, the temperature is held
};

template <class S>
struct TrajectorySettings {
  S heating_rate_1_s;  ///< greatest strain rate that the planner asks for, contracting
  S cooling_rate_1_s;  ///< and stretching; what the wire can do is less and always holds as well
  S lead_s;  ///< by which a set-point that streams is led: heat turns before the wire does
};

/// Limits that shape the output; none of them is a fault.
template <class S>
struct SoftLimits {
  S min_current_A;  ///< while running: keeps the resistance measurable
  S current_A;
  S power_W;
  S temperature_K;  ///< of the hottest spot
  S hot_spot_K;     ///< how far that may lie above the estimate
  S min_strain;     ///< shortest wire that is asked for
  S max_strain;
  S stress_Pa;
  S loss_margin;  ///< how much stronger than its file says a wire's cooling may be believed, where
                  ///< that would let it be heated at its temperature limit
  S duty;         ///< share of the current limit squared, averaged over duty_window_s
  S duty_window_s;
};

/// Limits whose crossing is a fault.
template <class S>
struct TripLimits {
  S current_A;
  S temperature_K;  ///< of the hottest spot
  S stress_Pa;
  S slack_Pa;  ///< below it the load is lost
  S min_strain, max_strain;
  S following_error;  ///< strain, for following_s
  S following_s;
  S heating_rate_K_s;
  S resistance_low, resistance_high;  ///< of the cold wire, as a share of what its file says
  S current_offset_A;                 ///< greatest zero-current reading at arming
  S min_ambient_K, max_ambient_K;
  S driver_K;            ///< temperature of the output stage
  S drift;               ///< of the resistance, relative: fatigue
  std::uint32_t cycles;  ///< full cycles before a warning
};

enum class SafeState : std::uint8_t {
  off,
  hold,     ///< holds strain for hold_s, then off
  release,  ///< cools at release_1_s, then off
};

template <class S>
struct SafeSettings {
  SafeState state;
  S hold_s;
  S release_1_s;  ///< strain rate
};

/// The profile that `host-sim identify` likes: full cycles, shrinking loops.
template <class S>
struct ProfileSettings {
  S overheat_K;  ///< level 1 ends so far above the finish of the transformation
  S cycle_s;     ///< of a full cycle
  S loop_s;      ///< of an inner loop
};

template <class S>
struct PositionSettings {
  S zero_strain;  ///< position 0; positions count contraction
};

template <class S>
struct Settings {
  Identity identity;
  Timing<S> timing;
  Wire<S> wire;
  Measuring<S> measuring;
  ObserverSettings<S> observer;
  DriveSettings<S> drive;
  LoopGains<S> strain, temperature, resistance, force;
  S feed_forward_s;  ///< in which the model's part brings the wire to its reference; 0: none
  S transfer_s;      ///< time constant in which a new mode or gain takes over
  TrajectorySettings<S> trajectory;
  SoftLimits<S> limits;
  TripLimits<S> trips;
  SafeSettings<S> safe;
  ProfileSettings<S> profile;
  PositionSettings<S> axis;
};

}  // namespace smaservo
