#pragma once
// The objects of the drive other than parameters and signals: those of CiA 402 and the
// manufacturer's services, as a plain struct and the table that describes it.

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "firmware/canopen/node/index.hpp"
#include "firmware/canopen/node/objects.hpp"
#include "firmware/safety/standing.hpp"

namespace smaservo::canopen {

/// Modes of 6060h. The negative ones are manufacturer-specific and set the heating directly.
enum class DriveMode : std::int8_t {
  identification = -4,
  temperature = -3,
  power = -2,
  current = -1,
  none = 0,
  profile_position = 1,
  profile_force = 4,
  homing = 6,
  cyclic_position = 8,
  cyclic_force = 10,
};

// Option codes: what happens to the heat.
inline constexpr std::int16_t option_off = 0;  ///< no current: the wire relaxes
/// 605Ah: holds the position and stays in Quick stop active.
inline constexpr std::int16_t option_hold = 6;
inline constexpr std::int16_t option_halt_hold = 1;   ///< 605Dh: holds the set-point
inline constexpr std::int16_t option_safe_state = 2;  ///< 605Eh: acts as safe.state says

/// 6502h: profile position, homing, cyclic position; with a force sensor also the two force modes.
/// The upper 16 bits are the manufacturer's modes -1 to -4.
constexpr std::uint32_t supported_modes(bool has_force) {
  constexpr std::uint32_t positions = 1U | 1U << 5U | 1U << 7U;
  constexpr std::uint32_t forces = 1U << 3U | 1U << 9U;
  return positions | (has_force ? forces : 0U) | 0x000F'0000U;
}

inline constexpr std::size_t channel_count = 8;

/// How often the cause of a warning has come; only for faults of warning_faults.
inline constexpr std::uint16_t warning_counts = 0x2203;
constexpr Key warning_count_key(Fault fault) {
  return {warning_counts, static_cast<std::uint8_t>(fault)};
}

struct DriveObjects {
  // CiA 402; positions in um, velocities in um/s, forces in 1/1000 of the rated one.
  std::int32_t demand, actual, velocity, target, home_offset, following_error, target_velocity;
  std::array<std::int32_t, 2> position_limit;
  std::uint32_t following_window, target_window, rated_force_mN, profile_velocity, force_slope;
  std::uint32_t position_unit, velocity_unit, supported_modes;
  std::uint16_t controlword, statusword, error_code, following_ms, target_ms;
  std::int16_t connection_option, quick_stop_option, shutdown_option, disable_option, halt_option,
      fault_option;
  std::int16_t target_force, force;
  std::int8_t mode, mode_display, homing_method, period_exponent;
  std::array<std::int8_t, 2> homing_methods;
  std::uint8_t period_value;
  // 2002h, 2003h
  std::uint8_t level;
  float command_source_timeout_s;
  // 2004h
  float sdo_segment_timeout_s, sdo_client_timeout_s;
  // 2102h
  float trial_s, client_timeout_s, remaining_s;
  std::uint32_t refused, refused_other;
  // 2201h
  std::array<float, 3> targets;  ///< current_A, power_W, temperature_K
  // 2202h
  std::array<std::uint32_t, 8> fault_bits;
  std::uint32_t limit_reasons;
  // 2203h
  WarningCounts warning_causes;
  // 2210h, 2211h
  std::array<std::uint32_t, 2> steps;
  std::array<float, 4> timing_s;
  std::array<std::uint32_t, 3> bus;
  std::array<float, 2> pdo_load;  ///< frames per second, per cent of the bit rate
  // 2220h
  std::uint32_t changes;
  // 2300h, 2301h
  std::uint32_t pretrigger, samples, capacity;
  float level_value, sample_period_s;
  // 2400h
  std::int32_t amplitude_um;
  std::uint32_t step_ms;
  std::array<float, 5> figures;
  std::uint16_t divisor;
  std::array<std::uint8_t, channel_count> channels;
  std::uint8_t tuning_state, first_cause, device_state;
  std::uint8_t recorder_state, trigger_signal, trigger_edge, step_state;
};

namespace detail {

constexpr std::uint32_t number(std::int32_t value) {
  return static_cast<std::uint32_t>(value);
}
constexpr unsigned sent = readable | in_tpdo;
constexpr unsigned driven = readable | operated | in_rpdo;
constexpr unsigned driven_and_sent = driven | in_tpdo;

constexpr std::size_t at_word(std::size_t array, std::size_t i) {
  return array + 4 * i;
}

/// The name of a warning's count: "warnings.heat_limit".
template <Fault fault>
inline constexpr auto warning_count_name = [] {
  constexpr std::string_view group = "warnings.";
  std::array<char, group.size() + fault_name(fault).size()> text{};
  std::ranges::copy(fault_name(fault), std::ranges::copy(group, text.begin()).out);
  return text;
}();

/// A row for each fault that may be a warning; the sub-index is the fault's number.
inline constexpr auto warning_rows = [] {
  std::array<DescribedObject, warning_count> rows{};
  const auto add = [&]<std::size_t number>() {
    constexpr auto fault = static_cast<Fault>(number);
    if constexpr (warning_faults.has(fault)) {
      constexpr auto& name = warning_count_name<fault>;
      rows.at(warning_index(fault)) =
          row(warning_count_key(fault), Type::u32, sent,
              at_word(offsetof(DriveObjects, warning_causes), warning_index(fault)),
              {name.data(), name.size()}, 0, "how often its cause has come since the start");
    }
  };
  [&]<std::size_t... number>(std::index_sequence<number...>) {
    (add.template operator()<number>(), ...);
  }(std::make_index_sequence<fault_count>{});
  return rows;
}();

/// 2002h to 2202h; after them comes 2203h.
inline constexpr auto command_rows = std::to_array<DescribedObject>({
    row({0x2002, 1}, Type::real, readable | set_up | stored,
        offsetof(DriveObjects, command_source_timeout_s), "command_source.timeout_s", as_bits(5.F),
        as_bits(0.05F), as_bits(5.F),
        "time without a command (set-point, mode, controlword) after which the command source has "
        "gone, where neither heartbeats nor event timers watch it; at most 1 s where commands come "
        "cyclically"),
    row({0x2003, 1}, Type::u8, readable, offsetof(DriveObjects, level), "access.level", 2,
        "0: operate, 1: tune, 2: set up"),
    row({0x2003, 2}, Type::u32, operated, nowhere, "access.key", 0,
        "write the key of a level to unlock it; any other number locks"),
    row({0x2004, 1}, Type::real, readable | tuned | stored,
        offsetof(DriveObjects, sdo_segment_timeout_s), "sdo.segment_timeout_s", as_bits(1.F),
        as_bits(0.1F), as_bits(60.F),
        "time without a segment after which a block download is given up; until then other clients "
        "are not answered"),
    row({0x2004, 2}, Type::real, readable | tuned | stored,
        offsetof(DriveObjects, sdo_client_timeout_s), "sdo.client_timeout_s", as_bits(5.F),
        as_bits(0.1F), as_bits(600.F),
        "time without the client's next request, or its acknowledgement of a block, after which "
        "any other transfer is given up"),
    row({0x2102, 1}, Type::u8, readable | tuned, nowhere, "tuning.command", 0, 0, 5,
        "1: begin, 2: try, 3: commit, 4: revert, 5: try and leave"),
    row({0x2102, 2}, Type::u8, sent, offsetof(DriveObjects, tuning_state), "tuning.state", 0,
        "0: none, 1: open, 2: on trial"),
    row({0x2102, 3}, Type::real, readable | tuned, offsetof(DriveObjects, trial_s),
        "tuning.trial_s", as_bits(30.F), as_bits(0.1F), as_bits(3600.F),
        "time after which a trial reverts by itself"),
    row({0x2102, 4}, Type::real, readable | tuned, offsetof(DriveObjects, client_timeout_s),
        "tuning.client_timeout_s", as_bits(5.F), as_bits(0.F), as_bits(3600.F),
        "time without an SDO request after which all is reverted, but what 5 has tried; 0: never"),
    row({0x2102, 5}, Type::real, sent, offsetof(DriveObjects, remaining_s), "tuning.remaining_s", 0,
        "time until the trial reverts"),
    row({0x2102, 6}, Type::u32, readable, offsetof(DriveObjects, refused), "tuning.refused", 0,
        "key of the parameter for which a set was refused: index << 16 | sub << 8"),
    row({0x2102, 7}, Type::u32, readable, offsetof(DriveObjects, refused_other),
        "tuning.refused_other", 0, "key of the parameter that it contradicts, in the same form"),
    row({0x2201, 1}, Type::real, readable | tuned | in_rpdo,
        at_word(offsetof(DriveObjects, targets), 0), "target.current_A", 0, as_bits(0.F),
        as_bits(25.F), "set-point of mode -1"),
    row({0x2201, 2}, Type::real, readable | tuned | in_rpdo,
        at_word(offsetof(DriveObjects, targets), 1), "target.power_W", 0, as_bits(0.F),
        as_bits(1000.F), "set-point of mode -2"),
    row({0x2201, 3}, Type::real, readable | tuned | in_rpdo,
        at_word(offsetof(DriveObjects, targets), 2), "target.temperature_K", 0, as_bits(0.F),
        as_bits(650.F), "set-point of mode -3"),
    row({0x2202, 1}, Type::u32, sent, at_word(offsetof(DriveObjects, fault_bits), 0),
        "faults.latched_low", 0, "not yet cleared; bit n: fault n"),
    row({0x2202, 2}, Type::u32, sent, at_word(offsetof(DriveObjects, fault_bits), 1),
        "faults.latched_high", 0, "bit n: fault 32 + n"),
    row({0x2202, 3}, Type::u32, sent, at_word(offsetof(DriveObjects, fault_bits), 2),
        "faults.active_low", 0, "present now; bit n: fault n"),
    row({0x2202, 4}, Type::u32, sent, at_word(offsetof(DriveObjects, fault_bits), 3),
        "faults.active_high", 0, "bit n: fault 32 + n"),
    row({0x2202, 5}, Type::u32, sent, at_word(offsetof(DriveObjects, fault_bits), 4),
        "faults.warnings_low", 0, "bit n: fault n"),
    row({0x2202, 6}, Type::u32, sent, at_word(offsetof(DriveObjects, fault_bits), 5),
        "faults.warnings_high", 0, "bit n: fault 32 + n"),
    row({0x2202, 7}, Type::u32, sent, at_word(offsetof(DriveObjects, fault_bits), 6),
        "faults.blocks_low", 0, "why the axis cannot be enabled; bit n: fault n"),
    row({0x2202, 8}, Type::u32, sent, at_word(offsetof(DriveObjects, fault_bits), 7),
        "faults.blocks_high", 0, "bit n: fault 32 + n"),
    row({0x2202, 9}, Type::u8, sent, offsetof(DriveObjects, first_cause), "faults.first_cause", 0,
        "number of the fault latched first; 0: none"),
    row({0x2202, 10}, Type::u8, sent, offsetof(DriveObjects, device_state), "device.state", 0,
        "0: starting, 1: ready, 2: arming, 3: running, 4: stopping, 5: fault"),
    row({0x2202, 11}, Type::u32, sent, offsetof(DriveObjects, limit_reasons),
        "device.limit_reasons", 0, "bit mask as in 2200h:23"),
});

/// From 2210h on.
inline constexpr auto service_rows = std::to_array<DescribedObject>({
    row({0x2210, 1}, Type::u32, sent, at_word(offsetof(DriveObjects, steps), 0), "loop.steps", 0,
        "since the start"),
    row({0x2210, 2}, Type::u32, sent, at_word(offsetof(DriveObjects, steps), 1), "loop.missed", 0,
        "cycles left out because their time had passed"),
    row({0x2210, 3}, Type::real, sent, at_word(offsetof(DriveObjects, timing_s), 0),
        "loop.mean_late_s", 0, "delay from the due time to the wake-up"),
    row({0x2210, 4}, Type::real, sent, at_word(offsetof(DriveObjects, timing_s), 1),
        "loop.max_late_s", 0, "delay from the due time to the wake-up"),
    row({0x2210, 5}, Type::real, sent, at_word(offsetof(DriveObjects, timing_s), 2),
        "loop.mean_busy_s", 0, "time that a step takes"),
    row({0x2210, 6}, Type::real, sent, at_word(offsetof(DriveObjects, timing_s), 3),
        "loop.max_busy_s", 0, "time that a step takes"),
    row({0x2211, 1}, Type::u32, sent, at_word(offsetof(DriveObjects, bus), 0), "bus.dropped", 0,
        "frames lost because the transmit queue was full"),
    row({0x2211, 2}, Type::u32, sent, at_word(offsetof(DriveObjects, bus), 1), "bus.off", 0,
        "how often the controller went bus-off"),
    row({0x2211, 3}, Type::u32, sent, at_word(offsetof(DriveObjects, bus), 2), "bus.queue_full", 0,
        "how often a frame had to wait because the queue was full"),
    row({0x2211, 4}, Type::real, readable, at_word(offsetof(DriveObjects, pdo_load), 0),
        "bus.pdo_frames_per_s", 0,
        "frames per second that the mapped TPDOs send at most, by their inhibit times; those of "
        "SYNC where 1006h gives its period"),
    row({0x2211, 5}, Type::real, readable, at_word(offsetof(DriveObjects, pdo_load), 1),
        "bus.pdo_load_percent", 0, "the same in per cent of the bit rate, 100: the bus is full"),
    row({0x2220, 1}, Type::u32, sent, offsetof(DriveObjects, changes), "changes.count", 0,
        "changes of parameters and other stored objects, and refused writes of any object"),
    row({0x2220, 2}, Type::domain, readable, nowhere, "changes.last", 0,
        "newest first: time in ms, index, sub-index, source, old and new value, abort code"),
    row({0x2300, 1}, Type::u8, readable | operated, nowhere, "recorder.command", 0, 0, 2,
        "0: stop, 1: arm, 2: trigger"),
    row({0x2300, 2}, Type::u8, sent, offsetof(DriveObjects, recorder_state), "recorder.state", 0,
        "0: idle, 1: armed, 2: triggered, 3: full"),
    row({0x2300, 3}, Type::u16, readable | operated, offsetof(DriveObjects, divisor),
        "recorder.divisor", 1, 1, 65535, "steps of the loop per sample"),
    row({0x2300, 4}, Type::u32, readable | operated, offsetof(DriveObjects, pretrigger),
        "recorder.pretrigger", 0, "samples before the trigger"),
    row({0x2300, 5}, Type::u8, readable | operated, offsetof(DriveObjects, trigger_signal),
        "recorder.trigger_signal", 0, "signal that triggers, as sub-index of 2200h; 0: at once"),
    row({0x2300, 6}, Type::u8, readable | operated, offsetof(DriveObjects, trigger_edge),
        "recorder.trigger_edge", 0, 0, 2, "0: rising, 1: falling, 2: either"),
    row({0x2300, 7}, Type::real, readable | operated, offsetof(DriveObjects, level_value),
        "recorder.trigger_level", 0, "in the unit of the signal"),
    row({0x2300, 8}, Type::u32, sent, offsetof(DriveObjects, samples), "recorder.samples", 0,
        "samples recorded"),
    row({0x2300, 9}, Type::u32, readable, offsetof(DriveObjects, capacity), "recorder.capacity", 0,
        "samples that fit, with the chosen channels"),
    row({0x2300, 10}, Type::real, readable, offsetof(DriveObjects, sample_period_s),
        "recorder.period_s", 0, "time between two samples"),
    row({0x2300, 11}, Type::domain, readable, nowhere, "recorder.data", 0,
        "REAL32: for each sample, oldest first, one value per channel; readable while full or "
        "stopped"),
    row({0x2301, 1}, Type::u8, readable | operated, offsetof(DriveObjects, channels) + 0,
        "recorder.channel_1", 17, "signal, as sub-index of 2200h; 0: none"),
    row({0x2301, 2}, Type::u8, readable | operated, offsetof(DriveObjects, channels) + 1,
        "recorder.channel_2", 12),
    row({0x2301, 3}, Type::u8, readable | operated, offsetof(DriveObjects, channels) + 2,
        "recorder.channel_3", 10),
    row({0x2301, 4}, Type::u8, readable | operated, offsetof(DriveObjects, channels) + 3,
        "recorder.channel_4", 3),
    row({0x2301, 5}, Type::u8, readable | operated, offsetof(DriveObjects, channels) + 4,
        "recorder.channel_5"),
    row({0x2301, 6}, Type::u8, readable | operated, offsetof(DriveObjects, channels) + 5,
        "recorder.channel_6"),
    row({0x2301, 7}, Type::u8, readable | operated, offsetof(DriveObjects, channels) + 6,
        "recorder.channel_7"),
    row({0x2301, 8}, Type::u8, readable | operated, offsetof(DriveObjects, channels) + 7,
        "recorder.channel_8"),
    row({0x2400, 1}, Type::u8, readable | operated, nowhere, "step.command", 0, 0, 1,
        "1: start, possible in Profile position and Operation enabled; 0: abort"),
    row({0x2400, 2}, Type::u8, sent, offsetof(DriveObjects, step_state), "step.state", 0,
        "0: none, 1: running, 2: done, 3: aborted"),
    row({0x2400, 3}, Type::i32, readable | operated, offsetof(DriveObjects, amplitude_um),
        "step.amplitude_um", 500, "contraction from the present position"),
    row({0x2400, 4}, Type::u32, readable | operated, offsetof(DriveObjects, step_ms),
        "step.duration_ms", 2000, 10, 600000,
        "time at the new position; the way back takes as long again"),
    row({0x2400, 5}, Type::real, sent, at_word(offsetof(DriveObjects, figures), 0), "step.rise_s",
        0, "rise time from 10 to 90 % of the amplitude; not a number: never reached"),
    row({0x2400, 6}, Type::real, sent, at_word(offsetof(DriveObjects, figures), 1),
        "step.overshoot", 0, "as a share of the amplitude"),
    row({0x2400, 7}, Type::real, sent, at_word(offsetof(DriveObjects, figures), 2),
        "step.settling_s", 0, "time after which the error stays within 5 % of the amplitude"),
    row({0x2400, 8}, Type::real, sent, at_word(offsetof(DriveObjects, figures), 3), "step.error_m",
        0, "mean error in the last quarter"),
    row({0x2400, 9}, Type::real, sent, at_word(offsetof(DriveObjects, figures), 4),
        "step.peak_temperature_K", 0, "highest estimated temperature"),
});

constexpr unsigned option = readable | operated | stored;
constexpr unsigned tuned_option = readable | tuned | stored;
constexpr unsigned set_up_option = readable | set_up | stored;

inline constexpr auto drive_rows = std::to_array<DescribedObject>({
    row({index::connection_option, 0}, Type::i16, set_up_option,
        offsetof(DriveObjects, connection_option), "Abort connection option code", 1, 0, 3,
        "0: nothing, 1: fault, 2: disable voltage, 3: quick stop"),
    row({index::error_code, 0}, Type::u16, sent, offsetof(DriveObjects, error_code), "Error code",
        0, "code of the fault: FAULTS.md"),
    row({index::controlword, 0}, Type::u16, driven_and_sent, offsetof(DriveObjects, controlword),
        "Controlword"),
    row({index::statusword, 0}, Type::u16, sent, offsetof(DriveObjects, statusword), "Statusword"),
    row({index::quick_stop_option, 0}, Type::i16, set_up_option,
        offsetof(DriveObjects, quick_stop_option), "Quick stop option code", 0, 0, 6,
        "0: heating off, the wire relaxes; 6: hold the position, stay in Quick stop active"),
    row({index::shutdown_option, 0}, Type::i16, set_up_option,
        offsetof(DriveObjects, shutdown_option), "Shutdown option code", 0, 0, 0,
        "0: heating off, the wire relaxes"),
    row({index::disable_option, 0}, Type::i16, set_up_option,
        offsetof(DriveObjects, disable_option), "Disable operation option code", 0, 0, 0,
        "0: heating off, the wire relaxes"),
    row({index::halt_option, 0}, Type::i16, set_up_option, offsetof(DriveObjects, halt_option),
        "Halt option code", 1, 0, 1, "0: heating off, the wire relaxes; 1: hold the set-point"),
    row({index::fault_option, 0}, Type::i16, set_up_option, offsetof(DriveObjects, fault_option),
        "Fault reaction option code", 0, 0, 2,
        "0: heating off; 2: as safe.state says, for faults of class F2"),
    row({index::mode, 0}, Type::i8, driven_and_sent, offsetof(DriveObjects, mode),
        "Modes of operation", 0,
        "-4: identification, -3: temperature, -2: power, -1: current, 1: profile position, "
        "4: profile force, 6: homing, 8: cyclic position, 10: cyclic force"),
    row({index::mode_display, 0}, Type::i8, sent, offsetof(DriveObjects, mode_display),
        "Modes of operation display"),
    row({index::position_demand, 0}, Type::i32, sent, offsetof(DriveObjects, demand),
        "Position demand value", 0, "um"),
    row({index::position_actual, 0}, Type::i32, sent, offsetof(DriveObjects, actual),
        "Position actual value", 0, "um"),
    row({index::following_window, 0}, Type::u32, tuned_option,
        offsetof(DriveObjects, following_window), "Following error window", 0xFFFFFFFF,
        "um; FFFFFFFFh: off, trips.following_error stays"),
    row({index::following_time, 0}, Type::u16, tuned_option, offsetof(DriveObjects, following_ms),
        "Following error time out", 0, "ms"),
    row({index::position_window, 0}, Type::u32, tuned_option, offsetof(DriveObjects, target_window),
        "Position window", 100, "um"),
    row({index::position_time, 0}, Type::u16, tuned_option, offsetof(DriveObjects, target_ms),
        "Position window time", 50, "ms"),
    row({index::velocity_actual, 0}, Type::i32, sent, offsetof(DriveObjects, velocity),
        "Velocity actual value", 0, "um/s"),
    row({index::target_torque, 0}, Type::i16, driven, offsetof(DriveObjects, target_force),
        "Target torque", 0, "force, in 1/1000 of 6076h"),
    row({index::rated_torque, 0}, Type::u32, tuned_option, offsetof(DriveObjects, rated_force_mN),
        "Motor rated torque", 1000, 1, 100'000'000, "rated force, mN"),
    row({index::torque_actual, 0}, Type::i16, sent, offsetof(DriveObjects, force),
        "Torque actual value", 0, "force, in 1/1000 of 6076h"),
    row({index::target_position, 0}, Type::i32, driven_and_sent, offsetof(DriveObjects, target),
        "Target position", 0, "um"),
    row({index::home_offset, 0}, Type::i32, tuned_option, offsetof(DriveObjects, home_offset),
        "Home offset", 0, "um"),
    row({index::position_limit, 1}, Type::i32, set_up_option,
        at_word(offsetof(DriveObjects, position_limit), 0), "Min position limit", 0x80000000,
        "um; not above the max position limit; targets beyond are limited, and so they are to what "
        "limits.min_strain and limits.max_strain allow, with bit 11 of the statusword"),
    row({index::position_limit, 2}, Type::i32, set_up_option,
        at_word(offsetof(DriveObjects, position_limit), 1), "Max position limit", 0x7FFFFFFF, "um"),
    row({index::profile_velocity, 0}, Type::u32, driven | stored,
        offsetof(DriveObjects, profile_velocity), "Profile velocity", 0,
        "um/s; 0: as fast as trajectory.* allows"),
    row({index::torque_slope, 0}, Type::u32, driven | stored, offsetof(DriveObjects, force_slope),
        "Torque slope", 1000, "slope of the force, in 1/1000 of 6076h per second"),
    row({index::homing_method, 0}, Type::i8, tuned_option, offsetof(DriveObjects, homing_method),
        "Homing method", 37, 35, 37, "35 and 37: the present position becomes the home position"),
    row({index::position_unit, 0}, Type::u32, readable, offsetof(DriveObjects, position_unit),
        "SI unit position", 0xFA010000, "um"),
    row({index::velocity_unit, 0}, Type::u32, readable, offsetof(DriveObjects, velocity_unit),
        "SI unit velocity", 0xFA010300, "um/s"),
    row({index::interpolation_period, 1}, Type::u8, option, offsetof(DriveObjects, period_value),
        "Interpolation time period value", 1,
        "period of the set-points of modes 8 and 10, which are interpolated over it: this value "
        "times ten to the power of 60C2h:2, in s"),
    row({index::interpolation_period, 2}, Type::i8, option, offsetof(DriveObjects, period_exponent),
        "Interpolation time index", number(-3), number(-6), 0),
    row({index::supported_homing, 1}, Type::i8, readable, offsetof(DriveObjects, homing_methods),
        "Supported homing method 1", 35),
    row({index::supported_homing, 2}, Type::i8, readable,
        offsetof(DriveObjects, homing_methods) + 1, "Supported homing method 2", 37),
    row({index::following_error, 0}, Type::i32, sent, offsetof(DriveObjects, following_error),
        "Following error actual value", 0, "um"),
    row({index::target_velocity, 0}, Type::i32, driven, offsetof(DriveObjects, target_velocity),
        "Target velocity", 0, "accepted without effect, since there is no velocity mode"),
    row({0x6502, 0}, Type::u32, readable, offsetof(DriveObjects, supported_modes),
        "Supported drive modes", supported_modes(true),
        "bit mask of CiA 402; modes 4 and 10 only with a force sensor"),
});

}  // namespace detail

static_assert(in_order(detail::command_rows) && in_order(detail::warning_rows) &&
              in_order(detail::service_rows) && in_order(detail::drive_rows));

inline constexpr auto drive_object_names = std::to_array<IndexName>({
    {0x2002, "Command source"},
    {0x2003, "Access"},
    {0x2004, "SDO server time-outs"},
    {0x2102, "Tuning transaction"},
    {0x2201, "Targets"},
    {0x2202, "Faults"},
    {warning_counts, "Warnings"},
    {0x2210, "Loop timing"},
    {0x2211, "Bus statistics"},
    {0x2220, "Change log"},
    {0x2300, "Recorder"},
    {0x2301, "Recorder channels"},
    {0x2400, "Step test"},
    {index::position_limit, "Software position limit"},
    {index::interpolation_period, "Interpolation time period"},
    {index::supported_homing, "Supported homing methods"},
});

/// The manufacturer's objects and those of CiA 402, sorted by key.
inline constexpr auto drive_object_rows = [] {
  using namespace detail;
  std::array<DescribedObject,
             command_rows.size() + warning_rows.size() + service_rows.size() + drive_rows.size()>
      rows{};
  auto* at = std::ranges::copy(command_rows, rows.begin()).out;
  at = std::ranges::copy(warning_rows, at).out;
  at = std::ranges::copy(service_rows, at).out;
  std::ranges::copy(drive_rows, at);
  return rows;
}();
static_assert(in_order(drive_object_rows));

}  // namespace smaservo::canopen
