#include "firmware/canopen/servo/axis.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "firmware/canopen/node/index.hpp"
#include "firmware/canopen/servo/duration.hpp"

namespace smaservo::canopen {
namespace {

// Controlword.
constexpr unsigned switch_on = 1, enable_voltage = 2, no_quick_stop = 4, enable_operation = 8;
constexpr unsigned new_setpoint_bit = 0x10, at_once = 0x20, relative = 0x40;
constexpr unsigned fault_reset = 0x80;
// Statusword.
constexpr unsigned voltage_enabled = 0x10, warning = 0x80, remote_bit = 0x200, reached_bit = 0x400,
                   limit_bit = 0x800, specific_12 = 0x1000, specific_13 = 0x2000;

constexpr std::array<std::uint16_t, 8> state_bits{0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08};

constexpr std::uint16_t following_code = 0x8611;
constexpr std::uint16_t not_armed_code = 0xFF50;
constexpr std::uint8_t steps_to_arm = 20;
constexpr float um = 1e6F;

bool rises(std::uint16_t before, std::uint16_t now, unsigned bit) {
  return (before & bit) == 0 && (now & bit) != 0;
}
std::int32_t rounded(float x) {
  constexpr float max = 2e9F;
  return std::isfinite(x)
             ? static_cast<std::int32_t>(std::lround(std::fmin(std::fmax(x, -max), max)))
             : 0;
}
std::int16_t rounded_16(float x) {
  return std::isfinite(x)
             ? static_cast<std::int16_t>(std::lround(std::fmin(std::fmax(x, -32767.F), 32767.F)))
             : std::int16_t{0};
}

}  // namespace

void Axis::reset(bool has_force) {
  const AxisFeedback last = in_;
  DriveObjects& objects = o_;
  const std::uint64_t now_us = now_us_;
  std::construct_at(this, objects);
  now_us_ = now_us;
  in_ = last;
  in_.device = DeviceState::starting;
  has_force_ = has_force;
  o_.supported_modes = supported_modes(has_force);
  show();
}

Abort Axis::check_mode(std::int32_t mode) const {
  switch (static_cast<DriveMode>(mode)) {
    case DriveMode::profile_force:
    case DriveMode::cyclic_force:
      return has_force_ ? Abort::none : Abort::value;
    case DriveMode::identification:
    case DriveMode::temperature:
    case DriveMode::power:
    case DriveMode::current:
    case DriveMode::none:
    case DriveMode::profile_position:
    case DriveMode::homing:
    case DriveMode::cyclic_position:
      return Abort::none;
  }
  return Abort::value;
}

/// Whether the value is a defined option code: not every number within a row's range is one.
Abort Axis::check_option(std::uint16_t index, std::int32_t value) {
  const bool known = index == index::quick_stop_option ? value == option_off || value == option_hold
                     : index == index::fault_option
                         ? value == option_off || value == option_safe_state
                     : index == index::homing_method ? value == 35 || value == 37
                                                     : true;
  return known ? Abort::none : Abort::value;
}

// States.

void Axis::controlword(std::uint16_t before, std::uint16_t now) {
  reset_edge_ = reset_edge_ || rises(before, now, fault_reset);
  if (state_ == DriveState::enabled && mode() == DriveMode::profile_position) {
    if (rises(before, now, new_setpoint_bit)) {
      new_setpoint(now);
    } else if ((now & new_setpoint_bit) == 0) {
      acknowledged_ = waits_;
    }
  }
  if (state_ == DriveState::enabled && mode() == DriveMode::homing &&
      rises(before, now, new_setpoint_bit)) {
    home();
  }
}

void Axis::feedback(const AxisFeedback& feedback) {
  in_ = feedback;
  clear_steps_ = clear_steps_ == 0 ? clear_steps_ : static_cast<std::uint8_t>(clear_steps_ - 1);
  watch_arming();
  const float shown_um = feedback.position_m * um + static_cast<float>(shift_um_);
  o_.actual = rounded(shown_um);
  o_.velocity = rounded(feedback.velocity_m_s * um);
  o_.force = rounded_16(feedback.force_N * um / static_cast<float>(o_.rated_force_mN));
  if (!moves_position() || !may_heat()) {
    // A position that is held from the next step on is the present position.
    stand_still();
    active_um_ = o_.actual;
    waits_ = moving_ = beyond_ = false;
  }
}

/// Raises a fault if the device does not arm, or stops without reporting a fault itself. The code
/// gives the reason.
void Axis::watch_arming() {
  if (state_ != DriveState::enabled) {
    heated_ = false;
    refused_ = 0;
    return;
  }
  if (is_heated(in_.device)) {
    heated_ = true;
    refused_ = 0;
  } else if (in_.device == DeviceState::ready) {
    refused_ = static_cast<std::uint8_t>(refused_ + 1);
    if (heated_ || steps_to_arm < refused_) {
      fail(in_.code != 0 ? in_.code : not_armed_code);
    }
  }
}

void Axis::fail(std::uint16_t code) {
  if (!own_fault_) {
    own_fault_ = own_fault_new_ = true;
    own_code_ = code;
  }
}

std::uint16_t Axis::take_own_fault() {
  const bool is_new = own_fault_new_;
  own_fault_new_ = false;
  return is_new ? own_code_ : std::uint16_t{0};
}

void Axis::advance(std::uint64_t now_us) {
  const float dt_s = std::fmin(seconds_of(now_us - now_us_), 0.1F);
  now_us_ = now_us;
  transition();
  set_mode();
  move(dt_s);
  watch_position(dt_s);
  show();
}

void Axis::transition() {
  if (in_.device == DeviceState::starting) {
    state_ = DriveState::not_ready;
    return;
  }
  if (state_ == DriveState::not_ready) {
    enter(DriveState::disabled);
    return;
  }
  if (!react_to_faults()) {
    // A fault reset also acknowledges conditions that block arming without being a fault, such as
    // unclean_boot.
    clear_steps_ = reset_edge_ && in_.blocked ? 3 : clear_steps_;
    reset_edge_ = false;
    command();
  }
}

/// Transitions caused by faults. False if there is no fault, so that the controlword decides.
bool Axis::react_to_faults() {
  const bool device_fault = in_.device == DeviceState::fault;
  const bool stopping = in_.device == DeviceState::stopping;
  if (state_ == DriveState::fault) {
    if (reset_edge_) {
      reset_fault();
    }
    if (!device_fault && !stopping && !own_fault_) {
      clear_steps_ = 0;
      o_.error_code = 0;
      enter(DriveState::disabled);
    }
    return true;
  }
  if (!device_fault && !stopping && !own_fault_ && state_ != DriveState::reacting) {
    return false;
  }
  o_.error_code = own_fault_ ? own_code_ : in_.code != 0 ? in_.code : o_.error_code;
  const bool device_decides = o_.fault_option == option_safe_state && is_heated(in_.device) &&
                              (state_ == DriveState::enabled || state_ == DriveState::quick_stop ||
                               state_ == DriveState::reacting) &&
                              (stopping || bus_lost_);
  if (device_decides) {
    enter(DriveState::reacting);
  } else {
    enter(state_ == DriveState::reacting ? DriveState::fault : DriveState::reacting);
  }
  return true;
}

void Axis::reset_fault() {
  reset_edge_ = false;
  own_fault_ = own_fault_new_ = false;
  bus_lost_ = false;
  clear_steps_ = 3;
}

/// At most one transition by the controlword.
void Axis::command() {
  using enum DriveState;
  const unsigned word = o_.controlword;
  if (state_ == disabled && (word & (fault_reset | no_quick_stop | enable_voltage | switch_on)) !=
                                (no_quick_stop | enable_voltage)) {
    return;
  }
  if ((word & fault_reset) != 0) {
    return;
  }
  if ((word & enable_voltage) == 0) {
    enter(disabled);
  } else if ((word & no_quick_stop) == 0) {
    const bool holds = state_ == enabled && o_.quick_stop_option == option_hold;
    if (state_ != DriveState::quick_stop) {
      enter(holds ? DriveState::quick_stop : disabled);
    }
  } else if (state_ == DriveState::quick_stop) {
    if ((word & (switch_on | enable_operation)) == (switch_on | enable_operation)) {
      enter(enabled);
    }
  } else if ((word & switch_on) == 0) {
    enter(ready);
  } else if (state_ == ready || (word & enable_operation) == 0) {
    enter(on);
  } else if (state_ == on && in_.device == DeviceState::ready && !in_.blocked) {
    enter(enabled);
  }
}

void Axis::enter(DriveState next) {
  if (next == state_) {
    return;
  }
  if (next == DriveState::enabled && state_ != DriveState::quick_stop) {
    heated_ = false;
    refused_ = 0;
  }
  if (next != DriveState::enabled) {
    acknowledged_ = waits_ = false;
  }
  if (next == DriveState::quick_stop) {
    stand_still();
  }
  state_ = next;
}

/// Makes the present position the set-point.
void Axis::stand_still() {
  ramp_um_ = static_cast<float>(o_.actual);
}

void Axis::stop() {
  state_ = DriveState::not_ready;
  o_.controlword = 0;
  acknowledged_ = waits_ = false;
  show();
}

void Axis::connection_lost(std::uint16_t code) {
  if (!may_heat()) {
    return;
  }
  switch (o_.connection_option) {
    case 1:
      bus_lost_ = true;
      fail(code);
      break;
    case 2:
      o_.controlword = 0;
      break;
    case 3:
      o_.controlword = static_cast<std::uint16_t>(o_.controlword & ~no_quick_stop);
      break;
    default:
      break;
  }
}

bool Axis::may_heat() const {
  return state_ == DriveState::enabled ||
         (state_ == DriveState::quick_stop && o_.quick_stop_option == option_hold) ||
         (state_ == DriveState::reacting && o_.fault_option == option_safe_state);
}

// Modes.

bool Axis::moves_position() const {
  return mode() == DriveMode::profile_position || mode() == DriveMode::homing ||
         mode() == DriveMode::cyclic_position || state_ == DriveState::quick_stop;
}

bool Axis::follows(Key key) const {
  switch (mode()) {
    case DriveMode::cyclic_position:
      return key == Key{index::target_position, 0};
    case DriveMode::cyclic_force:
      return key == Key{index::target_torque, 0};
    case DriveMode::current:
    case DriveMode::power:
    case DriveMode::temperature:
      return key == Key{0x2201, static_cast<std::uint8_t>(-o_.mode_display)};
    default:
      return false;
  }
}

void Axis::set_mode() {
  if (o_.mode_display == o_.mode) {
    return;
  }
  o_.mode_display = o_.mode;
  stand_still();
  active_um_ = o_.actual;
  moving_ = beyond_ = false;
  to_setpoint_s_ = 0;
  force_ = static_cast<float>(o_.force);
  acknowledged_ = waits_ = homed_ = false;
}

/// The target clamped to 607Dh and then to the reach, which has priority. Bit 11 of the statusword
/// shows that it had to be clamped, until the next target.
std::int32_t Axis::limited(std::int32_t target_um) {
  const auto [low, high] = o_.position_limit;
  const auto shift_um = static_cast<float>(shift_um_);
  const std::int32_t lowest = rounded(reach_.low_m * um + shift_um);
  const std::int32_t highest = rounded(reach_.high_m * um + shift_um);
  const std::int32_t allowed = target_um < low ? low : high < target_um ? high : target_um;
  const std::int32_t reachable = std::max(lowest, std::min(allowed, highest));
  beyond_ = reachable != target_um;
  return reachable;
}

/// A new set-point is followed at once, or waits until the present one is reached; a further one is
/// not acknowledged while another waits.
void Axis::new_setpoint(std::uint16_t word) {
  if (waits_ && (word & at_once) == 0) {
    return;
  }
  const std::int32_t base = waits_ ? waiting_um_ : active_um_;
  const std::int64_t sum = std::int64_t{o_.target} + ((word & relative) != 0 ? base : 0);
  constexpr std::int64_t max = 0x7FFF'FFFF;
  const auto target = limited(static_cast<std::int32_t>(sum < -max ? -max : max < sum ? max : sum));
  acknowledged_ = true;
  if ((word & at_once) != 0 || !moving_) {
    waits_ = false;
    start_move(target);
  } else {
    waits_ = true;
    waiting_um_ = target;
  }
}

void Axis::start_move(std::int32_t target_um) {
  active_um_ = target_um;
  moving_ = true;
  reached_ = false;
  within_s_ = 0;
}

/// Homing methods 35 and 37: the present position becomes the home position.
void Axis::home() {
  shift_um_ = o_.home_offset - (o_.actual - shift_um_);
  o_.actual = o_.home_offset;
  active_um_ = o_.actual;
  stand_still();
  homed_ = true;
}

void Axis::new_cyclic_setpoint() {
  // 60C2h:2, the exponent of ten, is -6 to 0.
  constexpr std::array unit_s{1.F, 1e-1F, 1e-2F, 1e-3F, 1e-4F, 1e-5F, 1e-6F};
  const auto unit = static_cast<std::size_t>(-o_.period_exponent);
  to_setpoint_s_ = static_cast<float>(o_.period_value) * unit_s[std::min(unit, unit_s.size() - 1)];
}

/// One step along the straight line that reaches `to` when the period of 60C2h has passed. New
/// set-points come with the same period, so they are joined by straight lines.
float Axis::interpolated(float from, float to, float dt_s) const {
  constexpr float rounding = 1.001F;
  return to_setpoint_s_ <= rounding * dt_s ? to : from + (to - from) * dt_s / to_setpoint_s_;
}

void Axis::move(float dt_s) {
  const bool halts = state_ == DriveState::enabled && halted();
  if (halts && !halted_before_) {
    stand_still();
  }
  halted_before_ = halts;
  if (state_ != DriveState::enabled || halts) {
    return;
  }
  move_position(dt_s);
  const float step = static_cast<float>(o_.force_slope) * dt_s;
  const auto target = static_cast<float>(o_.target_force);
  force_ = mode() == DriveMode::cyclic_force
               ? interpolated(force_, target, dt_s)
               : force_ + std::fmin(std::fmax(target - force_, -step), step);
  to_setpoint_s_ = std::fmax(to_setpoint_s_ - dt_s, 0.F);
  switch (mode()) {
    case DriveMode::current:
    case DriveMode::power:
    case DriveMode::temperature:
      held_ = o_.targets[static_cast<std::size_t>(-o_.mode_display) - 1];
      break;
    default:
      break;
  }
}

void Axis::move_position(float dt_s) {
  if (mode() == DriveMode::cyclic_position) {
    active_um_ = limited(o_.target);
    ramp_um_ = interpolated(ramp_um_, static_cast<float>(active_um_), dt_s);
  } else if (mode() == DriveMode::profile_position) {
    const auto target = static_cast<float>(active_um_);
    const float step = static_cast<float>(o_.profile_velocity) * dt_s;
    ramp_um_ = o_.profile_velocity == 0
                   ? target
                   : ramp_um_ + std::fmin(std::fmax(target - ramp_um_, -step), step);
    if (waits_ && reached_) {
      waits_ = false;
      start_move(waiting_um_);
      acknowledged_ = (o_.controlword & new_setpoint_bit) != 0;
    }
  }
}

void Axis::watch_position(float dt_s) {
  o_.demand = rounded(ramp_um_);
  o_.following_error = static_cast<std::int32_t>(std::int64_t{o_.demand} - o_.actual);
  if (state_ != DriveState::enabled || !moves_position()) {
    following_ = reached_ = false;
    missing_s_ = within_s_ = 0;
    return;
  }
  const auto error_um = static_cast<std::uint32_t>(std::abs(std::int64_t{o_.following_error}));
  const bool beyond = o_.following_window != 0xFFFF'FFFF && o_.following_window < error_um;
  missing_s_ = beyond ? missing_s_ + dt_s : 0;
  following_ = beyond && 1e-3F * static_cast<float>(o_.following_ms) <= missing_s_;
  if (following_) {
    fail(following_code);
  }
  // The demand has reached the target, and the wire has followed it into the window.
  const auto left_um = static_cast<std::uint64_t>(std::abs(std::int64_t{active_um_} - o_.actual));
  const bool is_there = o_.demand == active_um_ && left_um <= o_.target_window;
  within_s_ = is_there ? within_s_ + dt_s : 0;
  reached_ = is_there && 1e-3F * static_cast<float>(o_.target_ms) <= within_s_;
  moving_ = moving_ && !reached_;
}

AxisDemand Axis::demand() const {
  AxisDemand d;
  d.arm = may_heat();
  d.clear = clear_steps_ != 0;
  if (!d.arm) {
    return d;
  }
  const bool relaxes = halted() && o_.halt_option == option_off && state_ == DriveState::enabled;
  if (relaxes) {
    return d;
  }
  if (moves_position()) {
    d.mode = Mode::position;
    d.setpoint = (ramp_um_ - static_cast<float>(shift_um_)) / um;
    return d;
  }
  switch (mode()) {
    case DriveMode::profile_force:
    case DriveMode::cyclic_force:
      d.mode = Mode::force;
      d.setpoint = force_ * static_cast<float>(o_.rated_force_mN) / um;
      break;
    case DriveMode::current:
      d.mode = Mode::current;
      d.setpoint = held_;
      break;
    case DriveMode::power:
      d.mode = Mode::power;
      d.setpoint = held_;
      break;
    case DriveMode::temperature:
      d.mode = Mode::temperature;
      d.setpoint = held_;
      break;
    case DriveMode::identification:
      d.mode = Mode::identification;
      break;
    default:
      break;
  }
  return d;
}

// Statusword.

std::uint16_t Axis::mode_bits() const {
  unsigned bits = 0;
  switch (mode()) {
    case DriveMode::profile_position:
      bits |= reached_ || halted() ? reached_bit : 0U;
      bits |= acknowledged_ ? specific_12 : 0U;
      bits |= following_ ? specific_13 : 0U;
      break;
    case DriveMode::homing:
      bits |= reached_bit;
      bits |= homed_ ? specific_12 : 0U;
      break;
    case DriveMode::cyclic_position:
    case DriveMode::cyclic_force:
      bits |= !halted() ? specific_12 : 0U;
      bits |= following_ ? specific_13 : 0U;
      break;
    case DriveMode::profile_force:
      bits |= halted() || static_cast<std::int32_t>(force_) == o_.target_force ? reached_bit : 0U;
      break;
    default:
      break;
  }
  return static_cast<std::uint16_t>(bits);
}

void Axis::show() {
  unsigned word = state_bits[static_cast<std::size_t>(state_)];
  word |= in_.supplied ? voltage_enabled : 0U;
  word |= in_.warning ? warning : 0U;
  word |= remote_ ? remote_bit : 0U;
  word |= in_.limited || beyond_ ? limit_bit : 0U;
  word |= state_ == DriveState::enabled ? mode_bits() : 0U;
  o_.statusword = static_cast<std::uint16_t>(word);
}

}  // namespace smaservo::canopen
