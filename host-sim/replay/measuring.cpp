#include "host-sim/replay/measuring.hpp"

#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string>

#include "model/files/error.hpp"
#include "model/wire/plant.hpp"

namespace smaservo {

const std::vector<MeasurementSetting>& measurement_settings() {
  static const std::vector<MeasurementSetting> settings{
      {"measurement.current_offset_A", "read at zero current"},
      {"measurement.voltage_offset_V", "read at zero current"},
      {"measurement.current_noise_A", "standard deviation"},
      {"measurement.voltage_noise_V", "standard deviation"},
      {"measurement.lead_resistance_ohm", "of two-wire traces"},
      {"measurement.least_current_A", "below it there is no resistance"}};
  return settings;
}

MeasurementParams<double> measuring_params(const Wire<double>& wire,
                                           const std::vector<Override>& settings) {
  const double ohm = cold_resistance_ohm(wire);
  const double limit_A = wire.limits.current_A;
  MeasurementParams<double> p{
      wire.geometry.area_m2(), 0,         0,        1e-4 * limit_A, 1e-4 * limit_A * ohm, 0,
      0.03 * limit_A,          0.5 * ohm, 2.0 * ohm};
  for (const auto& [key, text] : settings) {
    double MeasurementParams<double>::* field = nullptr;
    if (key == "measurement.current_offset_A") field = &MeasurementParams<double>::current_offset_A;
    if (key == "measurement.voltage_offset_V") field = &MeasurementParams<double>::voltage_offset_V;
    if (key == "measurement.current_noise_A") field = &MeasurementParams<double>::current_noise_A;
    if (key == "measurement.voltage_noise_V") field = &MeasurementParams<double>::voltage_noise_V;
    if (key == "measurement.lead_resistance_ohm")
      field = &MeasurementParams<double>::lead_resistance_ohm;
    if (key == "measurement.least_current_A") field = &MeasurementParams<double>::least_current_A;
    double value = 0;
    const char* stop = text.data() + text.size();
    const auto [at, error] = std::from_chars(text.data(), stop, value);
    if (field == nullptr) {
      std::vector<std::string> keys;
      for (const MeasurementSetting& setting : measurement_settings()) {
        keys.emplace_back(setting.key);
      }
      throw UserError(
          fmt::format("--set {}: unknown key; measuring has: {}", key, fmt::join(keys, ", ")));
    }
    if (error != std::errc{} || at != stop || !(std::abs(value) < 1e6)) {
      throw UserError(fmt::format("--set {} = {}: must be a number below 1e6", key, text));
    }
    p.*field = value;
  }
  return p;
}

SplitSettings split_settings(const std::vector<Override>& settings) {
  SplitSettings split;
  for (const Override& setting : settings) {
    const bool measuring = setting.first.starts_with("measurement.");
    (measuring ? split.measurement : split.observer).push_back(setting);
  }
  return split;
}

}  // namespace smaservo
