#pragma once
// A lumped wire with its load and sensors, as a device would be connected to it.

#include <random>

#include "firmware/command.hpp"
#include "host-sim/tune/linear/operating_points.hpp"

namespace smaservo::tune {

class TunedBench {
 public:
  /// The wire is at rest. Current and voltage have white noise with these deviations, which is the
  /// same in each run.
  TunedBench(const TunedPlant& plant, double current_noise_A, double voltage_noise_V);

  /// Reads a new frame.
  Inputs<double> inputs();
  /// Applies this current for the next dt_s.
  void drive(double current_A, double dt_s);

  double strain() const { return LumpedModel::strain(params_, state_); }
  double temperature_K() const { return LumpedModel::temperature_K(state_); }
  double ohm() const { return LumpedModel::resistance_ohm(params_, state_, plant_.ambient_K); }

 private:
  TunedPlant plant_;
  LumpedModel::Params params_;
  LumpedModel::State state_;
  double rest_strain_;
  double current_noise_A_, voltage_noise_V_;
  double current_A_ = 0;
  double stress_Pa_;
  std::uint32_t sequence_ = 0;
  std::mt19937_64 random_{1};
  std::normal_distribution<double> normal_;
};

}  // namespace smaservo::tune
