#include "model/files/toml/fields.hpp"

#include <fmt/format.h>

namespace smaservo::files {
namespace {

struct Renamed {
  /// Beginnings of keys, the old one and the new one; longer ones stand first.
  std::string_view was, is;
};
constexpr Renamed all_renamed[] = {
    {"limits.", "wire.limits."},
    {"command_source_timeout_ms", "lost_after_ms"},
    {"partner_timeout_ms", "lost_after_ms"},
    {"partner.", "command_source."},
    {"partner_", "command_source_"},
    {"kinetics.", "wire."},
    {"material.reference", "wire.material.reference"},
    {"material.mixture", "wire.material.mixture"},
    {"material.", "wire."},
    {"heat.", "wire.heat."},
    {"accuracy.", "wire.accuracy."},
    {"measuring.", "measurement."},
    {"kalman.", "observer."},
    {"wire.martensite.resistivity_ohm_m_K", "wire.martensite.resistivity_temperature_ohm_m_K"},
    {"wire.martensite.resistivity_ohm_m_Pa", "wire.martensite.resistivity_stress_ohm_m_Pa"},
    {"wire.r_phase.resistivity_ohm_m_K", "wire.r_phase.resistivity_temperature_ohm_m_K"},
    {"wire.r_phase.resistivity_ohm_m_Pa", "wire.r_phase.resistivity_stress_ohm_m_Pa"},
    {"wire.austenite.resistivity_ohm_m_K", "wire.austenite.resistivity_temperature_ohm_m_K"},
    {"wire.austenite.resistivity_ohm_m_Pa", "wire.austenite.resistivity_stress_ohm_m_Pa"},
    {"wire.heat.convection_W_m2K2", "wire.heat.convection_slope_W_m2K2"},
    {"observer.ambient_sd_K", "observer.start_ambient_sd_K"},
    {"observer.loss_sd", "observer.start_loss_sd"}};

/// Beginnings of names that were changed in every table.
constexpr Renamed limits_renamed[] = {{"least_", "min_"}, {"greatest_", "max_"}};

}  // namespace

std::string renamed_key(std::string_view key) {
  for (const auto& [was, is] : all_renamed) {
    if (key.starts_with(was)) {
      return fmt::format("{}{}", is, key.substr(was.size()));
    }
    if (was.ends_with('.') && key == was.substr(0, was.size() - 1)) {
      return std::string(is.substr(0, is.size() - 1));
    }
  }
  for (const auto& [was, is] : limits_renamed) {
    if (key.substr(key.rfind('.') + 1).starts_with(was)) {
      const std::size_t at = key.rfind('.') + 1;
      return fmt::format("{}{}{}", key.substr(0, at), is, key.substr(at + was.size()));
    }
  }
  return {};
}

std::string key_with(std::string_view name, std::string_view suffix) {
  return suffix.empty() ? std::string(name) : fmt::format("{}_{}", name, suffix);
}

std::vector<KeyUnit> key_units(const Field& field) {
  std::vector<KeyUnit> units;
  for (const Unit& value : field.kind) {
    const std::string suffix(value.suffix);
    if (field.type != FieldType::polynomial) {
      units.push_back({suffix, value});
      continue;
    }
    for (const Unit& stress : {kind::stress[0], kind::stress[2]}) {
      const std::string prefix = suffix.empty() ? "" : suffix + "_";
      units.push_back({prefix + "by_" + std::string(stress.suffix), value, stress.factor});
    }
  }
  return units;
}

}  // namespace smaservo::files
