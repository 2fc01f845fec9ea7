#pragma once
// What stands around a simulated wire: its load and the sensors.

#include <limits>
#include <random>

#include "host-sim/scenario.hpp"

namespace smaservo {

/// The load's stress, step by step.
class LoadModel {
 public:
  explicit LoadModel(const Load& load);

  double stress_Pa() const { return stress_Pa_; }
  /// One step of dt_s, from the wire's strain before it. The longest wire of a spring is the first.
  void advance(double time_s, double dt_s, double strain, std::mt19937_64& random);

 private:
  Load load_;
  double stress_Pa_ = 0;
  double walk_Pa_ = 0;
  double longest_ = std::numeric_limits<double>::quiet_NaN();
};

/// What noisy and quantised sensors say.
struct Readings {
  double current_A, voltage_V, load_N;
};
Readings read_sensors(const Sensors& sensors, double current_A, double ohm, double load_N,
                      std::normal_distribution<double>& normal, std::mt19937_64& random);

}  // namespace smaservo
