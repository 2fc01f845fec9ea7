#pragma once
// Wires to observe: the model with other parameters than the observer's, and the distributed plant.

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>

#include "model/files/wire/wire_file.hpp"
#include "model/wire/distributed.hpp"
#include "model/wire/plant.hpp"
#include "observer/estimate.hpp"

namespace smaservo {

inline const Wire<double>& bench_wire() {
  static const Wire<double> wire = files::load_wire(std::string(files::default_wire)).wire;
  return wire;
}

/// How a wire and its surroundings differ from what the observer was told.
struct Deviations {
  double ambient_K = 0;
  double loss = 1;        ///< factor
  double resistance = 1;  ///< factor
  double heating_K = 0;   ///< shift of the transformation temperatures
  double cooling_K = 0;
  double resistance_noise_ohm = 0.01;
  double stress_noise_Pa = 0.3e6;
};

inline Deviations random_deviations(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return {2 * normal(random),
          1 + 0.07 * normal(random),
          1 + 0.003 * normal(random),
          1 * normal(random),
          1 * normal(random),
          0.01,
          0.3e6};
}

inline constexpr double told_ambient_K = room_K;
inline constexpr double sample_s = 1e-3;

/// Power that holds a wire of the observer's model this hot.
inline double holding_W(double temperature_K) {
  return plant_params(bench_wire()).body.loss_W(temperature_K - told_ambient_K);
}

/// A temperature at which a wire is surely austenite.
inline double hot_K(double stress_Pa) {
  const Isobar<double> m2a = isobar(bench_wire().kinetics.m2a, stress_Pa);
  return m2a.start_K + 1 / m2a.per_K + 25;
}

/// Adds the errors of the sensors.
class Sensors {
 public:
  Sensors(const Deviations& deviations, std::uint64_t seed)
      : deviations_(deviations), random_(seed) {}

  Measurement<double> read(double ohm, double power_W, double stress_Pa) {
    return {ohm * deviations_.resistance + deviations_.resistance_noise_ohm * normal_(random_),
            deviations_.resistance_noise_ohm,
            power_W,
            stress_Pa + deviations_.stress_noise_Pa * normal_(random_),
            true,
            true,
            true};
  }

 private:
  Deviations deviations_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

/// A wire with the same temperature along its whole length.
class LumpedWire {
 public:
  using Model = Plant<ThreePhase<double>>;

  LumpedWire(const Deviations& deviations, double stress_Pa, std::uint64_t seed)
      : sensors_(deviations, seed),
        params_(plant_params(bench_wire())),
        stress_Pa_(stress_Pa),
        ambient_K_(told_ambient_K + deviations.ambient_K) {
    params_.body.loss_W_K *= deviations.loss;
    params_.body.loss_W_K2 *= deviations.loss;
    auto& k = params_.kinetics;
    k.smallest_reversal_K = 0;
    k.m2a.start_K[0] += deviations.heating_K;
    k.m2a.finish_K[0] += deviations.heating_K;
    k.a2m_a2r.start_K[0] += Pair<double>(deviations.cooling_K);
    k.a2m_a2r.finish_K[0] += Pair<double>(deviations.cooling_K);
    state_ = Model::rest(params_, {ambient_K_, stress_Pa});
  }

  void place(double temperature_K, const Phases<double>& phases) {
    state_ = {
        ThreePhase<double>::with_phases(params_.kinetics, {temperature_K, stress_Pa_}, phases), 0};
  }

  Measurement<double> step(double power_W) {
    Model::advance(params_, state_, {power_W, stress_Pa_, ambient_K_}, sample_s);
    return sensors_.read(Model::resistance_ohm(params_, state_, ambient_K_), power_W, stress_Pa_);
  }
  double strain() const { return Model::strain(params_, state_); }

  /// The heat loss becomes this many times what it is now.
  void move_air(double factor) {
    params_.body.loss_W_K *= factor;
    params_.body.loss_W_K2 *= factor;
  }

 private:
  Sensors sensors_;
  Model::Params params_;
  Model::State state_{};
  double stress_Pa_;
  double ambient_K_;
};

/// A wire with cold clamps, heat conduction along it, and convection that depends on the
/// temperature.
class DistributedWire {
 public:
  static constexpr std::size_t segments = 24;
  using Model = DistributedPlant<ThreePhase<double>, segments>;

  DistributedWire(const Deviations& deviations, double stress_Pa, std::uint64_t seed)
      : sensors_(deviations, seed),
        draught_(deviations.loss),
        around_{stress_Pa, told_ambient_K + deviations.ambient_K} {
    const Wire<double>& wire = bench_wire();
    params_.material = wire.material;
    params_.heat = wire.heat;
    params_.geometry = wire.geometry;
    double sum = 0;
    for (std::size_t i = 0; i < segments; ++i) {
      const auto from_clamp = static_cast<int>(std::min(i, segments - 1 - i));
      params_.length_m[i] = std::pow(1.5, from_clamp);
      sum += params_.length_m[i];
    }
    for (std::size_t i = 0; i < segments; ++i) {
      params_.length_m[i] *= wire.geometry.length_m / sum;
      params_.kinetics[i] = wire.kinetics;
      params_.kinetics[i].smallest_reversal_K = 0;
    }
    state_ = Model::rest(params_, {around_.ambient_K, stress_Pa});
  }

  Measurement<double> step(double power_W) {
    const double ohm = Model::resistance_ohm(params_, state_);
    Model::advance(params_, state_, std::sqrt(power_W / ohm), around_, draught_, sample_s);
    return sensors_.read(Model::resistance_ohm(params_, state_), power_W, around_.stress_Pa);
  }
  double strain() const { return Model::strain(params_, state_); }

  /// The convection becomes this many times what it is now.
  void move_air(double factor) { draught_ *= factor; }

 private:
  Sensors sensors_;
  double draught_;
  Model::Params params_{};
  Model::Surroundings around_;
  Model::State state_{};
};

/// Power over time: two full cycles, then random levels.
class Profile {
 public:
  Profile(double stress_Pa, std::uint64_t seed)
      : random_(seed), full_W_(holding_W(hot_K(stress_Pa))) {}

  double power_W(double time_s) {
    if (time_s < 12) {
      return full_W_ * (std::fmod(time_s, 6) < 3 ? 1 : 0.03);
    }
    if (time_s >= until_s_) {
      level_ = std::uniform_real_distribution<double>(0.03, 1)(random_);
      until_s_ = time_s + std::uniform_real_distribution<double>(0.3, 2)(random_);
    }
    return full_W_ * level_;
  }

 private:
  std::mt19937_64 random_;
  double full_W_;
  double level_ = 0;
  double until_s_ = 0;
};

/// Quantile of some numbers.
inline double quantile(std::vector<double> values, double share) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

}  // namespace smaservo
