#pragma once
// What the parameters of an FMU are checked for, and what the FMUs show of a wire.

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "host-sim/fmu/unit/variables.hpp"
#include "model/wire/wire_check.hpp"
#include "model/wire/wire_plant.hpp"

namespace smaservo::fmu::unit {

/// A number for a message.
inline std::string shown(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// What the variable allows, for a message.
inline std::string allowed(const Variable& v) {
  switch (v.type) {
    case Type::choice:
      return "0 to " + shown(static_cast<double>(v.choices.size()) - 1);
    case Type::flag:
      return "0 or 1";
    case Type::whole:
    case Type::real:
      break;
  }
  const std::string kind = v.type == Type::whole ? "whole numbers" : "finite numbers";
  const std::string from = std::isnan(v.min) ? "" : " from " + shown(v.min);
  return kind + from + (std::isnan(v.max) ? "" : " to " + shown(v.max));
}

/// "" or what is wrong with a value.
inline std::string wrong_value(const Variable& v, double value) {
  return allows(v, value) ? "" : v.name + " = " + shown(value) + ": allowed are " + allowed(v);
}

/// "" or the first parameter or input whose value is not allowed.
inline std::string wrong_value(const std::vector<Variable>& variables,
                               const std::vector<double>& values) {
  for (std::size_t i = 0; i < variables.size(); ++i) {
    if (variables[i].role == Role::parameter || variables[i].role == Role::input) {
      std::string problem = wrong_value(variables[i], values[i]);
      if (!problem.empty()) {
        return problem;
      }
    }
  }
  return "";
}

/// "" or the first rule of a wire that does not hold; `before` stands in front of its parameters.
inline std::string wrong_wire(const Wire<double>& wire, const std::string& before = "") {
  using enum WireProblem::Rule;
  std::string first;
  check_wire_rules(wire, [&](const WireProblem& p) {
    if (!first.empty()) {
      return;
    }
    const std::string where = ", is " + shown(p.value) + " at " + shown(p.stress_Pa / 1e6) + " MPa";
    const auto between = [](double min, double max) {
      return " must be between " + shown(min) + " and " + shown(max);
    };
    first = before + std::string(p.process);
    if (p.rule == range_K) {
      first +=
          ": start and finish" + between(surface_range.min_K, surface_range.max_K) + " K" + where;
    } else if (p.rule == span_K) {
      first += ": finish must be at least " + shown(surface_range.min_span_K) + " K " +
               (p.heating ? "above" : "below") + " start" + where;
    } else if (p.rule == curvature) {
      first +=
          ".curvature" + between(surface_range.min_curvature, surface_range.max_curvature) + where;
    } else if (p.rule == turning) {
      first += ".turning" + between(surface_range.min_turning, surface_range.max_turning) + where;
    } else {
      first += "wire.heat.latent_r2a_J_kg must not be above wire.heat.latent_m2a_J_kg";
    }
  });
  return first;
}

/// Whether the plant has made its step.
inline bool is_made(const WireOutput<double>& out) {
  return std::isfinite(out.strain + out.resistance_ohm + out.temperature_K);
}

/// Writes the outputs of add_wire_outputs().
inline void show_wire(const WireOutput<double>& now, double length_m, double* out) {
  out[0] = now.strain;
  out[1] = now.strain * length_m;
  out[2] = now.resistance_ohm;
  out[3] = now.temperature_K;
  out[4] = now.martensite;
  out[5] = now.r_phase;
}

}  // namespace smaservo::fmu::unit
