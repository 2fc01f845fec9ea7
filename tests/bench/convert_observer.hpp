#pragma once
// The observer's parameters and samples in another scalar.

#include "observer/kalman.hpp"
#include "observer/measurement.hpp"
#include "tests/bench/convert.hpp"

namespace smaservo::benchmarks {

template <class To>
KalmanTuning<To> convert(const KalmanTuning<double>& from) {
  const auto to = [](double value) { return scalar<To>(value); };
  return {
      to(from.heat_error),          to(from.fraction_noise),     to(from.ambient_walk_K),
      to(from.loss_walk),           to(from.resistance_walk),    to(from.resistance_model_sd),
      to(from.resistance_bias),     to(from.stress_filter_s),    to(from.start_temperature_sd_K),
      to(from.start_fraction_sd),   to(from.start_ambient_sd_K), to(from.start_loss_sd),
      to(from.start_resistance_sd), to(from.ambient_range_K),    to(from.loss_range),
      to(from.resistance_range),    to(from.hottest_K),          to(from.reported),
      to(from.strain_model_sd)};
}

template <class To>
MeasurementParams<To> convert(const MeasurementParams<double>& from) {
  const auto to = [](double value) { return scalar<To>(value); };
  return {to(from.area_m2),         to(from.current_offset_A),   to(from.voltage_offset_V),
          to(from.current_noise_A), to(from.voltage_noise_V),    to(from.lead_resistance_ohm),
          to(from.min_current_A),   to(from.min_resistance_ohm), to(from.max_resistance_ohm)};
}

template <class To>
Sample<To> convert(const Sample<double>& from) {
  return {scalar<To>(from.current_A), scalar<To>(from.voltage_V), scalar<To>(from.load_N)};
}

}  // namespace smaservo::benchmarks
