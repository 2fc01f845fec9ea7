#pragma once
// Load and sensors of a simulated wire.

#include <limits>
#include <random>
#include <variant>

namespace smaservo::hal {

/// Load on the wire.
struct ConstantLoad {
  double stress_Pa;
};
struct SpringLoad {
  double low_Pa, high_Pa;  ///< stress when the wire is long, and when it is short
  double stroke;           ///< difference between the strains of the long and the short wire
  double lag_s;            ///< time constant of the mass that moves with the wire
};
struct VaryingLoad {
  double stress_Pa, amplitude_Pa, period_s;
  double walk_Pa;  ///< standard deviation of a random walk after 1 s; pulled back with a time
                   ///< constant of 3 s
  double min_Pa;
};
using Load = std::variant<ConstantLoad, SpringLoad, VaryingLoad>;

/// Computes the load's stress step by step.
class LoadModel {
 public:
  explicit LoadModel(const Load& load);

  double stress_Pa() const { return stress_Pa_; }
  /// Makes one step of dt_s with the wire's strain before it. A spring takes the first strain as
  /// that of the long wire.
  void advance(double time_s, double dt_s, double strain, std::mt19937_64& random);

 private:
  Load load_;
  double stress_Pa_ = 0;
  double walk_Pa_ = 0;
  double longest_ = std::numeric_limits<double>::quiet_NaN();
};

/// Errors and resolution of the sensors.
struct Sensors {
  int bits;
  double current_full_scale_A, voltage_full_scale_V, load_full_scale_N;
  double current_noise_A, voltage_noise_V, load_noise_N;
  double load_gain;
  double resistance_gain;  ///< factor by which the wire's resistance has drifted
};

/// Readings with noise and quantisation.
struct Readings {
  double current_A, voltage_V, load_N;
};
Readings read_sensors(const Sensors& sensors, double current_A, double ohm, double load_N,
                      std::normal_distribution<double>& normal, std::mt19937_64& random);

}  // namespace smaservo::hal
