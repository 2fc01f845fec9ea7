#pragma once
// What stands around a simulated wire: its load and the sensors.

#include <limits>
#include <random>
#include <variant>

namespace smaservo::hal {

/// Load on the wire.
struct ConstantLoad {
  double stress_Pa;
};
struct SpringLoad {
  double low_Pa, high_Pa;  ///< stress on the long and on the short wire
  double stroke;           ///< strain between the two
  double lag_s;            ///< of the mass that moves along
};
struct VaryingLoad {
  double stress_Pa, amplitude_Pa, period_s;
  double walk_Pa;  ///< per square root of a second, pulled back within 3 s
  double min_Pa;
};
using Load = std::variant<ConstantLoad, SpringLoad, VaryingLoad>;

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

/// What the sensors do to what they measure.
struct Sensors {
  int bits;
  double current_full_scale_A, voltage_full_scale_V, load_full_scale_N;
  double current_noise_A, voltage_noise_V, load_noise_N;
  double load_gain;
  double resistance_gain;  ///< what the wire's resistance has drifted by
};

/// What noisy and quantised sensors say.
struct Readings {
  double current_A, voltage_V, load_N;
};
Readings read_sensors(const Sensors& sensors, double current_A, double ohm, double load_N,
                      std::normal_distribution<double>& normal, std::mt19937_64& random);

}  // namespace smaservo::hal
