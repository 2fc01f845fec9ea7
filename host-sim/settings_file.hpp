#pragma once
// The settings of a device for a wire.

#include <string>
#include <vector>

#include "firmware/settings.hpp"
#include "host-sim/toml_table.hpp"
#include "model/wires/wire_file.hpp"

namespace smaservo {

inline Settings<double> settings_for(const Wire<double>& wire) {
  Settings<double> s{};
  s.identity = {1, 1};
  s.timing = {1e-3, 0.1, 0.005};
  s.wire = wire;
  s.measuring = {.current_offset_A = 0,
                 .voltage_offset_V = 0,
                 .load_offset_N = 0,
                 .load_gain = 1,
                 .current_noise_A = 1e-5,
                 .voltage_noise_V = 3e-4,
                 .lead_resistance_ohm = 0,
                 .constant_load_N = 0,
                 .has_load_cell = true,
                 .current_full_scale_A = 0.5,
                 .voltage_full_scale_V = 20};
  s.drive = {DriveKind::current, 0, 0, 5, 30};
  s.strain = {.proportional = 0,
              .integral_1_s = 0,
              .derivative_s = 0,
              .derivative_filter_s = 0.005,
              .setpoint_weight = 1,
              .derivative_weight = 0,
              .tracking_s = 0.05,
              .cooling_factor = 1,
              .dead_band = 1e-4};
  s.temperature = {0.05, 1, 0, 0.005, 1, 0, 0.05, 1, 0};
  s.resistance = {1, 1, 0, 0.005, 1, 0, 0.05, 1, 0};
  s.force = {20, 1, 0, 0.005, 1, 0, 0.05, 1, 0};
  s.feed_forward_s = 0.01;
  s.transfer_s = 0.01;
  s.trajectory = {0.35, 1};
  s.limits = {.least_current_A = 0.012,
              .current_A = 0.4,
              .power_W = 10,
              .temperature_K = 423.15,
              .hot_spot_K = 12,
              .least_strain = 0,
              .greatest_strain = 0.05,
              .stress_Pa = 500e6,
              .duty = 1,
              .duty_window_s = 10};
  s.trips = {.current_A = 0.45,
             .temperature_K = 433.15,
             .stress_Pa = 600e6,
             .slack_Pa = 1e6,
             .least_strain = -0.005,
             .greatest_strain = 0.06,
             .following_error = 0.01,
             .following_s = 2,
             .heating_rate_K_s = 1e4,
             .resistance_low = 0.8,
             .resistance_high = 1.2,
             .current_offset_A = 0.002,
             .least_ambient_K = 253.15,
             .greatest_ambient_K = 333.15,
             .driver_K = 358.15,
             .drift = 0.05,
             .cycles = 100000};
  s.safe = {SafeState::off, 0, 0.01};
  s.profile = {12, 5, 1.5};
  s.axis = {0.04};
  return s;
}

inline Settings<double> load_settings_file(const std::string& path,
                                           const std::vector<Override>& overrides = {}) {
  const TomlFile file(path);
  Table root = file.root();
  const std::string wire = root.text("wire");
  root.finish();
  return settings_for(
      load_wire(wire.ends_with(".toml") ? file.beside(wire) : wire, overrides).wire);
}

}  // namespace smaservo
