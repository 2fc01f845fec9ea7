#pragma once
// The numbers that a device reports in each step, described once: live values on CAN (2200h,
// sub-index by row), channels of the recorder, signals of the DBC, columns of a log. Each has one
// name in all of them, which is also what a recorded trace calls it: a reading is current_A, what
// the device asks for is drive_current_A. On the bus all are floats; positions count contraction
// from axis.zero_strain.
//
// Sub-indices are a protocol: new rows are appended, none is ever inserted, moved or removed.

#include <array>
#include <cstdint>
#include <string_view>
#include <utility>

#include "firmware/command.hpp"

namespace smaservo {

/// Quantities that need the settings, or the steps before, besides the present step.
struct Motion {
  float position_m, velocity_m_s, force_N, load_estimate_N;
};

/// What signals are read from.
template <class S>
struct SignalSource {
  const Output<S>& out;
  const Inputs<S>& in;
  Motion motion;
};

template <class S>
struct Signal {
  std::string_view name;  ///< with its unit
  std::string_view meaning;
  S (*read)(const SignalSource<S>& from);
};

template <class S>
inline constexpr auto signal_rows = [] {
  using From = const SignalSource<S>&;
  return std::to_array<Signal<S>>({
      {"strain", "estimated strain: elongation of the wire by its length",
       [](From f) { return f.out.estimate.strain; }},
      {"strain_sd", "standard deviation of that estimate's error, by the observer",
       [](From f) { return f.out.estimate.strain_sd; }},
      {"wire_temperature_K", "estimated temperature of the wire",
       [](From f) { return f.out.estimate.temperature_K; }},
      {"martensite", "estimated fraction of martensite",
       [](From f) { return f.out.estimate.martensite; }},
      {"r_phase", "estimated fraction of R-phase", [](From f) { return f.out.estimate.r_phase; }},
      {"resistance_ohm", "measured resistance",
       [](From f) { return f.out.measurement.resistance_ohm; }},
      {"resistance_model_ohm", "resistance that the model predicts",
       [](From f) { return f.out.estimate.resistance_model_ohm; }},
      {"stress_Pa", "measured stress", [](From f) { return f.out.measurement.stress_Pa; }},
      {"power_W", "measured electrical power into the wire",
       [](From f) { return f.out.measurement.power_W; }},
      {"drive_current_A", "current given to the output stage",
       [](From f) { return f.out.drive_current_A; }},
      {"drive_voltage_V", "voltage given to the output stage; drive.kind voltage",
       [](From f) { return f.out.drive_voltage_V; }},
      {"setpoint", "set-point in force, after limits, in the unit of the mode",
       [](From f) { return f.out.setpoint; }},
      {"reference", "reference of the planner, in the same unit",
       [](From f) { return f.out.reference; }},
      {"wanted_power_W", "power that the controller asks for, after limits",
       [](From f) { return f.out.wanted_power_W; }},
      {"estimated_ambient_K", "ambient temperature, as the observer estimates it",
       [](From f) { return f.out.estimated_ambient_K; }},
      {"hot_spot_K", "highest temperature to be expected along the wire",
       [](From f) { return f.out.hot_spot_K; }},
      {"position_m", "contraction from axis.zero_strain",
       [](From f) { return S(f.motion.position_m); }},
      {"velocity_m_s", "velocity of the position, filtered",
       [](From f) { return S(f.motion.velocity_m_s); }},
      {"force_N",
       "force: stress times cross section, or load_estimate_N while it pulls at axis.stop_strain",
       [](From f) { return S(f.motion.force_N); }},
      {"current_A", "current reading", [](From f) { return f.in.sample.current_A; }},
      {"voltage_V", "voltage reading", [](From f) { return f.in.sample.voltage_V; }},
      {"supply_V", "supply voltage of the output stage", [](From f) { return f.in.supply_V; }},
      {"limit_reasons",
       "bit mask; from bit 0: min_current, current, power, temperature, strain, stress, duty, "
       "supply, trajectory, protection",
       [](From f) { return S(static_cast<float>(f.out.limit_reasons)); }},
      {"cooling", "as a share of the wire file's, by the last test; 1 where it is not weaker",
       [](From f) { return f.out.cooling; }},
      {"load_estimate_N",
       "pull of the wire: the filtered load, or the estimate while it pulls at axis.stop_strain",
       [](From f) { return S(f.motion.load_estimate_N); }},
  });
}();

inline constexpr std::size_t signal_count = signal_rows<float>.size();
using Signals = std::array<float, signal_count>;

/// The row of a signal, by its name; an unknown name does not compile.
consteval std::size_t signal_index(std::string_view name) {
  std::size_t row = 0;
  while (signal_rows<float>.at(row).name != name) {
    ++row;
  }
  return row;
}

/// The index of the live values.
inline constexpr std::uint16_t live_values = 0x2200;

/// Sub-index of a signal in 2200h.
constexpr std::uint8_t sub_of(std::size_t signal) {
  return static_cast<std::uint8_t>(signal + 1);
}

/// All signals of a step. The rows are resolved at compile time: the program has neither their
/// texts nor calls through their pointers.
template <class S>
constexpr Signals read_signals(const SignalSource<S>& from) {
  return [&]<std::size_t... i>(std::index_sequence<i...>) {
    return Signals{static_cast<float>(signal_rows<S>[i].read(from))...};
  }(std::make_index_sequence<signal_count>{});
}

}  // namespace smaservo
