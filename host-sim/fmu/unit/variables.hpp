#pragma once
// The variables of an FMU: one list, from which the model description is written and which the
// shared library serves. A variable's place in the list is its value reference.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/units.hpp"
#include "model/wire/wire_parameters.hpp"

namespace smaservo::fmu::unit {

enum class Type : unsigned char { real, whole, choice, flag };

enum class Role : unsigned char {
  time,       ///< the independent variable
  parameter,  ///< may be set until initialization ends
  input,      ///< may be set at any time
  output,
};

constexpr double no_bound = std::numeric_limits<double>::quiet_NaN();

struct Variable {
  std::string name;
  Role role;
  Type type = Type::real;
  // NOLINTBEGIN(readability-redundant-member-init): for designated initializers
  std::string_view unit = {};  ///< of a real, as this project writes it: "ohm_m"; "": a number
  bool absolute_K = false;     ///< a temperature, not a difference of temperatures
  bool sampled = false;        ///< an output that changes at the cycles of the device alone
  double min = no_bound, max = no_bound;
  std::span<const std::string_view> choices = {};  ///< the names of a choice, by value
  std::string_view description = {};
  // NOLINTEND(readability-redundant-member-init)
};

/// Whether the value is one that the variable may have.
inline bool allows(const Variable& variable, double value) {
  if (!std::isfinite(value)) {
    return false;
  }
  switch (variable.type) {
    case Type::real:
      break;
    case Type::whole:
      if (value != static_cast<double>(static_cast<std::int64_t>(value))) {
        return false;
      }
      break;
    case Type::choice:
      return value >= 0 && value < static_cast<double>(variable.choices.size()) &&
             value == static_cast<double>(static_cast<std::int64_t>(value));
    case Type::flag:
      return value == 0 || value == 1;
  }
  return !(value < variable.min) && !(value > variable.max);
}

/// A row of a table of parameters as a parameter of an FMU.
inline Variable parameter_variable(std::string name, ValueType type, smaservo::Kind kind,
                                   double min, double max,
                                   std::span<const std::string_view> choices,
                                   std::string_view meaning) {
  Variable v{.name = std::move(name), .role = Role::parameter, .description = meaning};
  if (type == ValueType::real) {
    v.unit = kind.front().suffix;
    v.absolute_K = kind.data() == kind::temperature.data();
    v.min = min;
    v.max = max;
  } else if (type == ValueType::choice) {
    v.type = Type::choice;
    v.choices = choices;
  } else if (type == ValueType::boolean) {
    v.type = Type::flag;
  } else {
    v.type = Type::whole;
    v.min = min;
    v.max = max;
  }
  return v;
}

/// The surfaces of its own that a wire has. They decide which parameters it has, so they are
/// constants of an FMU.
struct Surfaces {
  bool r2a, r2m;
};

inline Surfaces surfaces_of(const Wire<double>& wire) {
  return {wire.kinetics.separate_r2a, wire.kinetics.separate_r2m};
}

/// Whether a row of wire_parameters is a parameter of an FMU whose wire has these surfaces.
inline bool is_variable(const WireParameter<double>& row, Surfaces surfaces) {
  const bool is_surface = row.type == ValueType::boolean;
  return !is_surface && (row.needs == Needs::nothing ||
                         (row.needs == Needs::own_r2a ? surfaces.r2a : surfaces.r2m));
}

/// Adds the parameters of a wire; `before` is put in front of their paths.
inline void add_wire_parameters(std::vector<Variable>& all, Surfaces surfaces,
                                const std::string& before = "") {
  for (const WireParameter<double>& row : wire_parameters<double>) {
    if (is_variable(row, surfaces)) {
      all.push_back(parameter_variable(before + std::string(row.path.text()), row.type, row.kind,
                                       row.min, row.max, row.choices, row.meaning));
    }
  }
}

/// The wire whose parameters begin at this place of the values; `next` becomes the place behind.
inline Wire<double> read_wire(const std::vector<double>& values, std::size_t& next,
                              Surfaces surfaces) {
  Wire<double> wire{};
  wire.kinetics.separate_r2a = surfaces.r2a;
  wire.kinetics.separate_r2m = surfaces.r2m;
  for (const WireParameter<double>& row : wire_parameters<double>) {
    if (is_variable(row, surfaces)) {
      row.set(wire, values[next++]);
    }
  }
  return wire;
}

/// The opposite: appends the values of a wire's parameters.
inline void append_wire(std::vector<double>& values, const Wire<double>& wire) {
  for (const WireParameter<double>& row : wire_parameters<double>) {
    if (is_variable(row, surfaces_of(wire))) {
      values.push_back(row.get(wire));
    }
  }
}

/// A number over names, types and roles of all variables: a library and a file of values that do
/// not belong together differ in it.
inline std::uint64_t interface_of(const std::vector<Variable>& variables) {
  std::uint64_t hash = 0xCBF29CE484222325U;
  const auto add = [&](unsigned char byte) { hash = (hash ^ byte) * 0x100000001B3U; };
  for (const Variable& v : variables) {
    for (const char letter : v.name) {
      add(static_cast<unsigned char>(letter));
    }
    add(static_cast<unsigned char>(v.type));
    add(static_cast<unsigned char>(0x80U | static_cast<unsigned char>(v.role)));
  }
  return hash;
}

}  // namespace smaservo::fmu::unit
