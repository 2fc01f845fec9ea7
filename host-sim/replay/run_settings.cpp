#include "host-sim/replay/run_settings.hpp"

#include "model/files/toml/toml_fields.hpp"
#include "observer/kalman.hpp"

namespace smaservo::replay {
namespace {

std::vector<RunKey> make_run_keys() {
  std::vector<RunKey> keys;
  const auto add = [&](const char* path, Kind kind, double min, double max, auto member) {
    keys.push_back(
        {{path, files::FieldType::number, kind, min, max, keys.size(), 1, {}, ""}, member});
  };
  using Tuning = KalmanTuning<double>;
  const auto tune = [&](const char* path, Kind kind, double Tuning::* member) {
    add(path, kind, member == &Tuning::loss_range ? 1 : 1e-12, 1e9, member);
  };
  tune("observer.heat_error", kind::count, &Tuning::heat_error);
  tune("observer.fraction_noise", kind::count, &Tuning::fraction_noise);
  tune("observer.ambient_walk", kind::temperature_difference, &Tuning::ambient_walk_K);
  tune("observer.loss_walk", kind::count, &Tuning::loss_walk);
  tune("observer.resistance_walk", kind::count, &Tuning::resistance_walk);
  tune("observer.resistance_model_sd", kind::count, &Tuning::resistance_model_sd);
  tune("observer.resistance_bias", kind::count, &Tuning::resistance_bias);
  tune("observer.stress_filter", kind::time, &Tuning::stress_filter_s);
  tune("observer.start_temperature_sd", kind::temperature_difference,
       &Tuning::start_temperature_sd_K);
  tune("observer.start_fraction_sd", kind::count, &Tuning::start_fraction_sd);
  tune("observer.start_ambient_sd", kind::temperature_difference, &Tuning::start_ambient_sd_K);
  tune("observer.start_loss_sd", kind::count, &Tuning::start_loss_sd);
  tune("observer.start_resistance_sd", kind::count, &Tuning::start_resistance_sd);
  tune("observer.ambient_range", kind::temperature_difference, &Tuning::ambient_range_K);
  tune("observer.loss_range", kind::count, &Tuning::loss_range);
  tune("observer.resistance_range", kind::count, &Tuning::resistance_range);
  tune("observer.hottest", kind::temperature, &Tuning::hottest_K);
  tune("observer.reported", kind::count, &Tuning::reported);
  tune("observer.strain_model_sd", kind::count, &Tuning::strain_model_sd);

  using Params = MeasurementParams<double>;
  const auto measurement = [&](const char* path, Kind kind, double Params::* member) {
    add(path, kind, -1e6, 1e6, member);
  };
  measurement("measurement.current_offset", kind::current, &Params::current_offset_A);
  measurement("measurement.voltage_offset", kind::voltage, &Params::voltage_offset_V);
  measurement("measurement.current_noise", kind::current, &Params::current_noise_A);
  measurement("measurement.voltage_noise", kind::voltage, &Params::voltage_noise_V);
  measurement("measurement.lead_resistance", kind::resistance, &Params::lead_resistance_ohm);
  measurement("measurement.min_current", kind::current, &Params::min_current_A);
  return keys;
}

}  // namespace

const std::vector<RunKey>& run_keys() {
  static const std::vector<RunKey> keys = make_run_keys();
  return keys;
}

bool is_run_setting(const std::string& key) {
  const std::string now = files::renamed_key(key);
  const std::string& name = now.empty() ? key : now;
  return name.starts_with("observer.") || name.starts_with("measurement.");
}

RunSettings parse_run_settings(const std::vector<files::Override>& settings) {
  static const std::vector<files::Field> fields = [] {
    std::vector<files::Field> all;
    for (const RunKey& key : run_keys()) {
      all.push_back(key.field);
    }
    return all;
  }();
  RunSettings parsed;
  for (const files::Override& setting : settings) {
    files::overlay(parsed, files::read_fields(fields, files::parse_override(setting),
                                              std::string(files::set_origin)));
  }
  return parsed;
}

}  // namespace smaservo::replay
