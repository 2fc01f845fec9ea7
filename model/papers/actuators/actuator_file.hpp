#pragma once
// Descriptions of spring-biased actuators (model/papers/duhem_actuator.hpp): TOML files with all
// their parameters. The presets of this folder are built into the program.

#include <span>
#include <string>
#include <string_view>

#include "model/papers/duhem_actuator.hpp"

namespace smaservo::papers {

/// One .toml file of this folder.
struct ActuatorPreset {
  std::string_view name;
  std::string_view text;
};
std::span<const ActuatorPreset> actuator_presets();

/// A preset's name or the path of a file that ends in ".toml". All keys are required, in any unit
/// of their kind; others are refused. Throws ConfigError.
DuhemActuator<double>::Params load_actuator(const std::string& name_or_path);

/// Like load_actuator(), from text; `origin` names it in error messages.
DuhemActuator<double>::Params parse_actuator(std::string_view text, const std::string& origin);

/// Table I of paper 001.
inline constexpr std::string_view paper_001_actuator = "spring-biased-381um";

}  // namespace smaservo::papers
