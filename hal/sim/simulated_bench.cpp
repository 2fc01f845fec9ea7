#include "hal/sim/simulated_bench.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace smaservo::hal {
namespace {

double quantised(double value, double full_scale, int bits) {
  const double step = full_scale / std::ldexp(1.0, bits - 1);
  return std::clamp(std::round(value / step) * step, -full_scale, full_scale);
}

}  // namespace

LoadModel::LoadModel(const Load& load) : load_(load) {
  if (const auto* constant = std::get_if<ConstantLoad>(&load_)) {
    stress_Pa_ = constant->stress_Pa;
  } else if (const auto* spring = std::get_if<SpringLoad>(&load_)) {
    stress_Pa_ = spring->low_Pa;
  } else {
    stress_Pa_ = std::get<VaryingLoad>(load_).stress_Pa;
  }
}

void LoadModel::advance(double time_s, double dt_s, double strain, std::mt19937_64& random) {
  if (const auto* spring = std::get_if<SpringLoad>(&load_)) {
    longest_ = std::isnan(longest_) ? strain : longest_;
    const double share = std::clamp((longest_ - strain) / spring->stroke, 0.0, 1.0);
    const double goal = spring->low_Pa + share * (spring->high_Pa - spring->low_Pa);
    stress_Pa_ += (goal - stress_Pa_) * dt_s / spring->lag_s;
  } else if (const auto* varying = std::get_if<VaryingLoad>(&load_)) {
    std::normal_distribution<double> normal;
    walk_Pa_ += varying->walk_Pa * std::sqrt(dt_s) * normal(random) - walk_Pa_ * dt_s / 3;
    const double wave = std::sin(2 * std::numbers::pi * time_s / varying->period_s);
    stress_Pa_ =
        std::max(varying->min_Pa, varying->stress_Pa + varying->amplitude_Pa * wave + walk_Pa_);
  }
}

Readings read_sensors(const Sensors& sensors, double current_A, double ohm, double load_N,
                      std::normal_distribution<double>& normal, std::mt19937_64& random) {
  Readings r{};
  // Each noise value is drawn in its own statement: the order must not depend on the compiler.
  r.current_A = quantised(current_A + sensors.current_noise_A * normal(random),
                          sensors.current_full_scale_A, sensors.bits);
  r.voltage_V = quantised(
      current_A * ohm * sensors.resistance_gain + sensors.voltage_noise_V * normal(random),
      sensors.voltage_full_scale_V, sensors.bits);
  r.load_N = quantised(load_N * sensors.load_gain + sensors.load_noise_N * normal(random),
                       sensors.load_full_scale_N, sensors.bits);
  return r;
}

}  // namespace smaservo::hal
