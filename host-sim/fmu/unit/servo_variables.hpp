#pragma once
// The variables of the FMU of a servo: the device of this project with its sensors and its output
// stage on a wire.

#include <algorithm>
#include <array>
#include <limits>

#include "firmware/command.hpp"
#include "firmware/parameters/parameters.hpp"
#include "firmware/safety/faults/table.hpp"
#include "host-sim/fmu/unit/wire_variables.hpp"

namespace smaservo::fmu::unit {

inline constexpr auto mode_choices =
    std::to_array<std::string_view>({"off", "current", "power", "resistance", "temperature",
                                     "strain", "position", "force", "identification"});
static_assert(mode_choices.size() == mode_count);

inline constexpr auto state_choices = std::to_array<std::string_view>(
    {"starting", "ready", "arming", "running", "stopping", "fault"});
static_assert(state_choices.size() == device_state_count);

/// What may be the matter with the path of the current.
inline constexpr auto circuit_choices =
    std::to_array<std::string_view>({"closed", "broken", "open"});

inline constexpr auto fault_choices = [] {
  std::array<std::string_view, fault_count> names{};
  for (std::size_t i = 0; i < fault_count; ++i) {
    names.at(i) = fault_name(static_cast<Fault>(i));
  }
  return names;
}();

/// The inputs, by their order.
enum class ServoInput : unsigned char {
  enable,
  mode,
  setpoint,
  clear_faults,
  emergency_stop,
  load_N,
  ambient_K,
  draught,
  supply_V,
  circuit,
  current_fails,
  voltage_fails,
  load_fails,
  count
};
constexpr std::size_t servo_inputs_at = 1;
constexpr std::size_t servo_outputs_at =
    servo_inputs_at + static_cast<std::size_t>(ServoInput::count);

/// The outputs behind those of the wire, by their order.
enum class ServoOutput : unsigned char {
  current_A,
  voltage_V,
  power_W,
  drive_current_A,
  estimated_strain,
  estimated_strain_sd,
  estimated_displacement_m,
  estimated_temperature_K,
  estimated_ambient_K,
  hot_spot_K,
  state,
  mode,
  setpoint,
  reference,
  wanted_power_W,
  limit_reasons,
  cycles,
  first_cause,
  latched  ///< the first of the words of latched, warnings and blocks
};
/// A word holds this many faults, so that a single-precision signal carries it, too.
constexpr unsigned faults_in_word = 24;
constexpr std::size_t fault_words = 3;
static_assert(fault_words * faults_in_word >= fault_count);
constexpr std::size_t servo_output_count =
    static_cast<std::size_t>(ServoOutput::latched) + 3 * fault_words;

constexpr std::size_t servo_parameters_at =
    servo_outputs_at + wire_state_count + servo_output_count;

/// The parameters of sensors and output stage, by their order.
enum class BoardParameter : unsigned char {
  bits,
  current_full_scale_A,
  voltage_full_scale_V,
  load_full_scale_N,
  current_noise_A,
  voltage_noise_V,
  load_noise_N,
  load_gain,
  resistance_gain,
  seed,
  reads_supply,
  reads_ambient,
  reads_driver,
  driver_above_K,
  max_A,
  slew_A_s,
  lead_ohm,
  count
};

/// Whether a row of the device's parameters is one of the FMU. Its identity has no meaning here.
inline bool is_variable(const Parameter<double>& row, Surfaces surfaces) {
  const std::string_view path = row.path.text();
  const bool is_surface = path == "wire.separate_r2a" || path == "wire.separate_r2m";
  return !path.starts_with("identity.") && !is_surface &&
         (row.needs == Needs::nothing ||
          (row.needs == Needs::own_r2a ? surfaces.r2a : surfaces.r2m));
}

/// A parameter of the device as an FMU has it.
inline double as_number(const ParameterRow<double>& row, Value value) {
  return row.type == ValueType::real ? static_cast<double>(value.real())
                                     : static_cast<double>(value.number());
}

/// Rounds the reals of the device's parameters, which begin at this place, to float, as a device
/// has them.
inline void round_settings(std::vector<double>& values, std::size_t next, Surfaces surfaces) {
  for (const Parameter<double>& row : parameters<double>) {
    if (is_variable(row, surfaces)) {
      double& value = values[next++];
      // A value beyond float's range stays, to be refused.
      constexpr auto greatest = static_cast<double>(std::numeric_limits<float>::max());
      if (row.type == ValueType::real && -greatest <= value && value <= greatest) {
        value = static_cast<double>(static_cast<float>(value));
      }
    }
  }
}

/// The settings whose parameters begin at this place of the values, which are allowed; `next`
/// becomes the place behind.
inline Settings<double> read_settings(const std::vector<double>& values, std::size_t& next,
                                      Surfaces surfaces) {
  Settings<double> settings = default_settings<double>();
  settings.wire.kinetics.separate_r2a = surfaces.r2a;
  settings.wire.kinetics.separate_r2m = surfaces.r2m;
  for (const Parameter<double>& row : parameters<double>) {
    if (is_variable(row, surfaces)) {
      const double value = values[next++];
      row.set(settings, row.type == ValueType::real
                            ? Value::real(static_cast<float>(value))
                            : Value::number(static_cast<std::uint32_t>(value)));
    }
  }
  return settings;
}

/// The opposite: appends the values of the settings' parameters.
inline void append_settings(std::vector<double>& values, const Settings<double>& settings) {
  for (const Parameter<double>& row : parameters<double>) {
    if (is_variable(row, surfaces_of(settings.wire))) {
      values.push_back(as_number(row, row.get(settings)));
    }
  }
}

namespace detail {

inline void add_servo_inputs(std::vector<Variable>& all) {
  const auto flag = [&](const char* name, std::string_view meaning) {
    all.push_back({.name = name, .role = Role::input, .type = Type::flag, .description = meaning});
  };
  flag("enable", "the device is to run, where the mode is not off; a falling edge disarms it");
  all.push_back({.name = "mode",
                 .role = Role::input,
                 .type = Type::choice,
                 .choices = mode_choices,
                 .description = "the variable that is controlled"});
  all.push_back(
      {.name = "setpoint",
       .role = Role::input,
       .description = "in SI units of the mode: A, W, ohm, K, strain, m of contraction, N"});
  flag("clear_faults", "clears latched faults whose cause is gone");
  flag("emergency_stop", "the board's emergency stop");
  all.push_back(load_input());
  all.push_back(ambient_input());
  all.push_back(draught_input());
  all.push_back({.name = "supply_V",
                 .role = Role::input,
                 .unit = "V",
                 .min = 0,
                 .max = 1000,
                 .description = "supply of the output stage"});
  all.push_back({.name = "circuit",
                 .role = Role::input,
                 .type = Type::choice,
                 .choices = circuit_choices,
                 .description = "broken: the wire is torn; open: a current lead is loose"});
  flag("current_fails", "the reading of the current is missing");
  flag("voltage_fails", "the reading of the voltage is missing");
  flag("load_fails", "the reading of the load is missing");
}

inline void add_servo_outputs(std::vector<Variable>& all) {
  add_wire_outputs(all);
  const auto real = [&](const char* name, std::string_view unit, bool sampled,
                        std::string_view meaning) {
    all.push_back({.name = name,
                   .role = Role::output,
                   .unit = unit,
                   .absolute_K = unit == "K",
                   .sampled = sampled,
                   .description = meaning});
  };
  const auto whole = [&](std::string name, std::string_view meaning) {
    all.push_back({.name = std::move(name),
                   .role = Role::output,
                   .type = Type::whole,
                   .sampled = true,
                   .description = meaning});
  };
  const auto choice = [&](const char* name, std::span<const std::string_view> choices,
                          std::string_view meaning) {
    all.push_back({.name = name,
                   .role = Role::output,
                   .type = Type::choice,
                   .sampled = true,
                   .choices = choices,
                   .description = meaning});
  };
  real("current_A", "A", false, "true current through the wire");
  real("voltage_V", "V", false, "true voltage of the wire");
  real("power_W", "W", false, "true heating power");
  real("drive_current_A", "A", true, "current that the device asks for");
  real("estimate.strain", "", true, "strain as the device estimates it");
  real("estimate.strain_sd", "", true, "its standard deviation");
  real("estimate.displacement_m", "m", true, "estimate.strain times wire.length_m");
  real("estimate.temperature_K", "K", true, "temperature of the wire as estimated");
  real("estimate.ambient_K", "K", true, "temperature of the air as estimated");
  real("hot_spot_K", "K", true, "highest temperature to be expected anywhere along the wire");
  choice("state", state_choices, "state of the device");
  choice("mode_in_force", mode_choices, "off where no current is allowed");
  real("setpoint_in_force", "", true, "after limits, in the unit of the mode");
  real("reference", "", true, "of the trajectory, in the unit of the mode");
  real("wanted_power_W", "W", true, "heating power that the controller asks for");
  whole("limit_reasons", "bit 1 << reason: why the output is not what the loop wants");
  whole("cycles", "of the device since the beginning");
  choice("first_cause", fault_choices, "the fault that was latched first");
  constexpr std::array sets{"latched", "warnings", "blocks"};
  constexpr std::array<std::string_view, 3> meanings{
      "faults that are latched: bit n of word w is fault 24 w + n", "warnings, in the same way",
      "what keeps the device from being armed, in the same way"};
  for (std::size_t set = 0; set < sets.size(); ++set) {
    for (std::size_t word = 0; word < fault_words; ++word) {
      whole(std::string(sets[set]) + "_" + std::to_string(word), meanings[set]);
    }
  }
}

inline void add_board_parameters(std::vector<Variable>& all) {
  constexpr double most = 1e6;
  const auto real = [&](const char* name, std::string_view unit, double min, double max,
                        std::string_view meaning) {
    all.push_back({.name = name,
                   .role = Role::parameter,
                   .unit = unit,
                   .min = min,
                   .max = max,
                   .description = meaning});
  };
  const auto whole = [&](const char* name, double min, double max, std::string_view meaning) {
    all.push_back({.name = name,
                   .role = Role::parameter,
                   .type = Type::whole,
                   .min = min,
                   .max = max,
                   .description = meaning});
  };
  const auto flag = [&](const char* name, std::string_view meaning) {
    all.push_back(
        {.name = name, .role = Role::parameter, .type = Type::flag, .description = meaning});
  };
  whole("sensors.bits", 8, 32, "resolution of the readings of current, voltage and load");
  real("sensors.current_full_scale_A", "A", 1e-3, 100, "greatest reading");
  real("sensors.voltage_full_scale_V", "V", 0.1, 1000, "greatest reading");
  real("sensors.load_full_scale_N", "N", 0.01, 1e5, "greatest reading");
  real("sensors.current_noise_A", "A", 0, 1, "standard deviation of the noise; 0: none");
  real("sensors.voltage_noise_V", "V", 0, 1, "standard deviation of the noise; 0: none");
  real("sensors.load_noise_N", "N", 0, 1e3, "standard deviation of the noise; 0: none");
  real("sensors.load_gain", "", 0.5, 1.5, "factor of the load cell that the device does not know");
  real("sensors.resistance_gain", "", 0.8, 1.2,
       "factor by which the wire's resistance has drifted");
  whole("sensors.seed", 0, 1e9, "of the noise: the same seed gives the same noise");
  flag("board.reads_supply", "the device has a sensor of the supply");
  flag("board.reads_ambient", "the device has a sensor of the air");
  flag("board.reads_driver", "the device has a sensor of the output stage");
  real("board.driver_above_K", "K", 0, 200, "temperature of the output stage above the air");
  real("board.max_A", "A", 1e-3, 100, "current at which the output stage saturates");
  real("board.slew_A_s", "A_s", 0.01, most, "greatest rise of the current");
  real("board.lead_ohm", "ohm", 0, 1e4, "resistance of the leads, outside of the sense leads");
}

}  // namespace detail

/// `device`: surfaces of the wire in the device's settings; `plant`: of the wire that it drives.
inline std::vector<Variable> servo_variables(Surfaces device, Surfaces plant) {
  std::vector<Variable> all{
      {.name = "time", .role = Role::time, .unit = "s", .description = "simulated time"}};
  detail::add_servo_inputs(all);
  detail::add_servo_outputs(all);
  for (const Parameter<double>& row : parameters<double>) {
    if (is_variable(row, device)) {
      // An integer of FMI has 32 bits with a sign.
      const double max =
          row.type == ValueType::number
              ? std::min(as_number(row, row.max), double{std::numeric_limits<std::int32_t>::max()})
              : as_number(row, row.max);
      all.push_back(parameter_variable(std::string(row.path.text()), row.type, row.kind,
                                       as_number(row, row.min), max, row.choices, row.meaning));
    }
  }
  detail::add_board_parameters(all);
  add_wire_parameters(all, plant, "true.");
  return all;
}

}  // namespace smaservo::fmu::unit
