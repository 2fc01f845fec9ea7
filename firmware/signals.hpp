#pragma once
// What a device tells of each step, described once: live values on CAN (2200h, sub-index by row),
// channels of the recorder, signals of the DBC. All are floats; positions count contraction from
// axis.zero_strain.

#include <array>
#include <cstdint>
#include <string_view>

namespace smaservo {

enum class Signal : std::uint8_t {
  strain,
  strain_sd,
  temperature_K,
  martensite,
  r_phase,
  resistance_ohm,
  resistance_model_ohm,
  stress_Pa,
  power_W,
  current_A,
  voltage_V,
  setpoint,
  reference,
  wanted_power_W,
  ambient_K,
  hot_spot_K,
  position_m,
  velocity_m_s,
  force_N,
  measured_A,
  measured_V,
  supply_V,
  limit_reasons,
  count
};
inline constexpr std::size_t signal_count = static_cast<std::size_t>(Signal::count);
using Signals = std::array<float, signal_count>;

/// The sub-index of 2200h.
constexpr std::uint8_t sub_of(Signal signal) {
  return static_cast<std::uint8_t>(static_cast<unsigned>(signal) + 1U);
}

struct SignalRow {
  std::string_view name;  ///< with its unit
  std::string_view meaning;
};

inline constexpr std::array<SignalRow, signal_count> signal_rows{{
    {"strain", "elongation of the wire, as estimated"},
    {"strain_sd", "standard deviation of its error, as the observer sees it"},
    {"temperature_K", "of the wire, as estimated"},
    {"martensite", "share"},
    {"r_phase", "share"},
    {"resistance_ohm", "measured"},
    {"resistance_model_ohm", "that the model expects"},
    {"stress_Pa", "by the load"},
    {"power_W", "measured, into the wire"},
    {"current_A", "given"},
    {"voltage_V", "given, to a drive that takes one"},
    {"setpoint", "in force, in the unit of the mode"},
    {"reference", "of the planner, in the same unit"},
    {"wanted_power_W", "by the controller, after limits"},
    {"ambient_K", "air, as the observer believes"},
    {"hot_spot_K", "hottest that the wire may be"},
    {"position_m", "contraction from axis.zero_strain"},
    {"velocity_m_s", "of the position, filtered"},
    {"force_N", "load"},
    {"measured_A", "current"},
    {"measured_V", "voltage"},
    {"supply_V", "of the drive"},
    {"limit_reasons", "bits, see firmware/command.hpp"},
}};

constexpr float& of(Signals& signals, Signal signal) {
  return signals[static_cast<std::size_t>(signal)];
}
constexpr float of(const Signals& signals, Signal signal) {
  return signals[static_cast<std::size_t>(signal)];
}

}  // namespace smaservo
