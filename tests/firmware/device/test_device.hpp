#pragma once
// A device as the tests set it up, and the lumped wire that it drives.

#include <limits>

#include "firmware/device/device.hpp"
#include "model/files/wire/wire_file.hpp"
#include "tests/bench/convert.hpp"

namespace smaservo {

/// Settings for a preset wire on a bench with little noise, with generous limits.
template <class S = double>
Settings<S> test_settings(const Wire<double>& wire = files::load_wire("smartflex-76um").wire) {
  Settings<S> s{};
  s.identity = {1, 1};
  s.timing = {S(1e-3), S(0.1), S(0.005)};
  s.wire = benchmarks::convert<S>(wire);
  s.measurement = {.current_offset_A = S(0),
                   .voltage_offset_V = S(0),
                   .load_offset_N = S(0),
                   .load_gain = S(1),
                   .current_noise_A = S(1e-5),
                   .voltage_noise_V = S(3e-4),
                   .lead_resistance_ohm = S(0),
                   .constant_load_N = S(0),
                   .has_load_cell = true,
                   .current_full_scale_A = S(0.5),
                   .voltage_full_scale_V = S(20)};
  s.observer = {S(18), S(0.3)};
  s.drive = {DriveKind::current, S(0), S(0), S(5), S(30)};
  s.strain = {.proportional = S(0),
              .integral_1_s = S(0),
              .derivative_s = S(0),
              .derivative_filter_s = S(0.005),
              .setpoint_weight = S(1),
              .derivative_weight = S(0),
              .tracking_s = S(0.05),
              .cooling_factor = S(1),
              .dead_band = S(1e-4)};
  s.temperature = {S(0.05), S(1), S(0), S(0.005), S(1), S(0), S(1), S(1), S(0)};
  s.resistance = {S(1), S(1), S(0), S(0.005), S(1), S(0), S(1), S(1), S(0)};
  s.force = {S(20), S(1), S(0), S(0.005), S(1), S(0), S(1), S(1), S(0)};
  s.feed_forward_s = S(0.01);
  s.transfer_s = S(0.01);
  s.trajectory = {S(0.35), S(1), S(0.03)};
  s.limits = {.min_current_A = S(0.012),
              .current_A = S(0.4),
              .power_W = S(10),
              .temperature_K = S(423.15),
              .hot_spot_K = S(12),
              .min_strain = S(0),
              .max_strain = S(0.05),
              .stress_Pa = S(500e6),
              .loss_margin = S(1.15),
              .duty = S(1),
              .duty_window_s = S(10)};
  s.trips = {.current_A = S(0.45),
             .temperature_K = S(433.15),
             .stress_Pa = S(600e6),
             .slack_Pa = S(1e6),
             .min_strain = S(-0.005),
             .max_strain = S(0.06),
             .following_error = S(0.01),
             .following_s = S(2),
             .heating_rate_K_s = S(1e4),
             .resistance_low = S(0.8),
             .resistance_high = S(1.2),
             .current_offset_A = S(0.002),
             .min_ambient_K = S(253.15),
             .max_ambient_K = S(333.15),
             .driver_K = S(358.15),
             .drift = S(0.05),
             .cycles = 100000};
  s.safe = {SafeState::off, S(0), S(0.01)};
  s.profile = {S(12), S(5), S(1.5)};
  s.axis = {S(0.04), S(0)};
  return s;
}

/// A wire of one temperature behind clean sensors, at rest.
class TestBench {
 public:
  using Model = Plant<ThreePhase<double>>;

  explicit TestBench(const Wire<double>& wire, double stress_Pa, double ambient_K = room_K)
      : params_(plant_params(wire)),
        state_(Model::rest(params_, {ambient_K, stress_Pa})),
        area_m2_(wire.geometry.area_m2()),
        stress_Pa_(stress_Pa),
        ambient_K_(ambient_K) {}

  template <class S = double>
  Inputs<S> inputs() {
    const S nan = std::numeric_limits<S>::quiet_NaN();
    Inputs<S> in{};
    in.fresh = true;
    in.sequence = sequence_++;
    in.sample = {scalar<S>(current_A_), scalar<S>(current_A_ * resistance_ohm()),
                 scalar<S>(stress_Pa_ * area_m2_)};
    in.supply_V = S(24);
    in.ambient_K = nan;
    in.driver_K = nan;
    return in;
  }
  /// Lets this current flow for dt_s.
  void advance(double current_A, double dt_s) {
    current_A_ = current_A;
    Model::advance(params_, state_,
                   {current_A * current_A * resistance_ohm(), stress_Pa_, ambient_K_}, dt_s);
  }
  const Model::Params& params() const { return params_; }
  const Model::State& state() const { return state_; }
  double strain() const { return Model::strain(params_, state_); }
  double temperature_K() const { return Model::temperature_K(state_); }
  double resistance_ohm() const { return Model::resistance_ohm(params_, state_, ambient_K_); }
  double stress_Pa() const { return stress_Pa_; }
  void ambient(double ambient_K) { ambient_K_ = ambient_K; }
  void stress(double stress_Pa) { stress_Pa_ = stress_Pa; }

 private:
  Model::Params params_;
  Model::State state_;
  double area_m2_, stress_Pa_, ambient_K_;
  double current_A_ = 0;
  std::uint32_t sequence_ = 0;
};

}  // namespace smaservo
