#pragma once
// The variables of the FMU of a wire.

#include "host-sim/fmu/unit/variables.hpp"

namespace smaservo::fmu::unit {

/// The inputs, from this value reference on.
constexpr std::size_t wire_inputs_at = 1;
constexpr std::size_t wire_input_count = 4;
/// The outputs follow them, then the parameters.
constexpr std::size_t wire_outputs_at = wire_inputs_at + wire_input_count;
constexpr std::size_t wire_output_count = 8;
constexpr std::size_t wire_parameters_at = wire_outputs_at + wire_output_count;

/// The inputs that a wire has in both FMUs.
inline Variable load_input() {
  return {.name = "load_N",
          .role = Role::input,
          .unit = "N",
          .description = "force that pulls at the wire"};
}
inline Variable ambient_input() {
  return {.name = "ambient_K",
          .role = Role::input,
          .unit = "K",
          .absolute_K = true,
          .min = 1,
          .max = 2000,
          .description = "temperature of the air and of the clamps"};
}
inline Variable draught_input() {
  return {.name = "draught",
          .role = Role::input,
          .min = 1e-3,
          .max = 1e3,
          .description = "factor on the heat loss of still air"};
}

/// Adds what a wire shows of itself, the first outputs of both FMUs: strain, displacement_m,
/// resistance_ohm, temperature_K, martensite, r_phase.
constexpr std::size_t wire_state_count = 6;
inline void add_wire_outputs(std::vector<Variable>& all) {
  const auto output = [&](const char* name, std::string_view unit, std::string_view meaning) {
    all.push_back({.name = name,
                   .role = Role::output,
                   .unit = unit,
                   .absolute_K = unit == "K",
                   .description = meaning});
  };
  output("strain", "", "elongation of the whole wire, greatest in cold martensite");
  output("displacement_m", "m", "strain times wire.length_m: greater where the wire is longer");
  output("resistance_ohm", "ohm", "resistance of the wire");
  output("temperature_K", "K", "temperature of the wire without its cold ends");
  output("martensite", "", "mean fraction of martensite over the whole wire");
  output("r_phase", "", "mean fraction of R-phase; austenite is the rest");
}

inline std::vector<Variable> wire_variables(Surfaces surfaces) {
  std::vector<Variable> all{
      {.name = "time", .role = Role::time, .unit = "s", .description = "simulated time"},
      {.name = "current_A",
       .role = Role::input,
       .unit = "A",
       .description = "current through the wire"},
      load_input(),
      ambient_input(),
      draught_input()};
  add_wire_outputs(all);
  all.push_back({.name = "voltage_V",
                 .role = Role::output,
                 .unit = "V",
                 .description = "current of the last step times the present resistance"});
  all.push_back({.name = "power_W",
                 .role = Role::output,
                 .unit = "W",
                 .description = "voltage_V times the current of the last step"});
  add_wire_parameters(all, surfaces);
  return all;
}

}  // namespace smaservo::fmu::unit
