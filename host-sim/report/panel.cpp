#include "host-sim/report/panel.hpp"

#include <algorithm>
#include <stdexcept>

namespace smaservo::report {

Column column(std::vector<double> values) {
  return std::make_shared<const std::vector<double>>(std::move(values));
}

bool shows(const Column& values) {
  return std::ranges::any_of(*values, [](double value) { return std::isfinite(value); });
}

const std::vector<Role>& colours() {
  static const std::vector<Role> all{
      {"estimate", "#0059b3", "#6cb2ff"},   {"reference", "#d95f02", "#ff9a4d"},
      {"measured", "#8c8c8c", "#9aa3ad"},   {"planned", "#228833", "#5fc974"},
      {"band", "#bfd7ee", "#2c4a6b"},       {"reference_band", "#f6d5bd", "#63401f"},
      {"warning", "#ddaa33", "#e6bd5c"},    {"fault", "#b00020", "#ff6678"},
      {"heating", "#c8102e", "#ff6b6b"},    {"cooling", "#2166ac", "#6cb2ff"},
      {"martensite", "#4477aa", "#5b8fc4"}, {"r_phase", "#ddaa33", "#c9a040"},
      {"austenite", "#dd99a0", "#b5737b"},  {"ink", "#111111", "#f0f0f0"},
      {"faint", "#bbbbbb", "#5a6068"}};
  return all;
}

std::string_view on_white(std::string_view colour) {
  if (colour.starts_with('#')) {
    return colour;
  }
  const auto role = std::ranges::find(colours(), colour, &Role::name);
  if (role == colours().end()) {
    throw std::logic_error("no such colour: " + std::string(colour));
  }
  return role->light;
}

}  // namespace smaservo::report
