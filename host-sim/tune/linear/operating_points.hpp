#pragma once
// A wire under its load, linearised along both branches of its hysteresis: from power to
// temperature, and from temperature to each variable that a loop controls.

#include <string>
#include <vector>

#include "model/wire/plant.hpp"

namespace smaservo::tune {

/// A constant load (stroke 0), or a spring: a straight line from the stress on the wire at rest to
/// that on one shorter by `stroke`.
struct TunedLoad {
  double low_Pa, high_Pa;
  double stroke;

  bool is_spring() const { return stroke > 0; }
  /// On a wire that is `shorter` than at rest, a strain.
  double stress_Pa(double shorter) const {
    return is_spring() ? low_Pa + shorter / stroke * (high_Pa - low_Pa) : low_Pa;
  }
};

/// A wire, its load and its surroundings.
struct TunedPlant {
  Wire<double> wire;
  TunedLoad load;
  double ambient_K;
  double draught = 1;  ///< factor on the wire's loss
};

using LumpedModel = Plant<ThreePhase<double>>;
/// The plant's parameters, with the draught in the loss.
LumpedModel::Params lumped_params(const TunedPlant& plant);

/// One step of a wire with its load, which moves along without mass; its stress afterwards.
double advance_loaded(const TunedPlant& plant, const LumpedModel::Params& params,
                      LumpedModel::State& state, double power_W, double rest_strain, double dt_s);

enum class Motion : unsigned char {
  heating,  ///< contracts
  cooling,  ///< stretches
  turned,   ///< between the branches: it has turned, and keeps its strain
};
std::string motion_name(Motion motion);

/// A wire in motion. C dT/dt = P - loss; everything else follows the temperature at once.
struct OperatingPoint {
  Motion motion;
  double share;  ///< of the stroke by which the wire has contracted
  LumpedModel::State state;
  double stress_Pa, strain, ohm, temperature_K;
  double capacity_J_K;  ///< with the latent heat, and what the load adds by its stress
  double loss_W, loss_slope_W_K;
  double strain_1_K, ohm_1_K,
      load_N_K;  ///< slopes over temperature, with the load following the strain
};

struct Branches {
  double rest_strain;  ///< cold, at ambient temperature
  double hot_strain;   ///< as short as the limits let it become
  double hottest_K;    ///< temperature at hot_strain
  double hot_Pa;       ///< stress at hot_strain
  double min_ohm, max_ohm;
  double heat_J;     ///< for the whole stroke from rest, without losses
  double cooling_s;  ///< time from 90 % to 10 % of the stroke without current
  double fastest_cooling_1_s;
  std::vector<OperatingPoint> points;  ///< of each branch at equal shares, and three turned ones

  double stroke() const { return rest_strain - hot_strain; }
};

/// Traces a full cycle from rest, up to 12 K beyond the transformation or to `max_K`, in steps of
/// 0.02 K, with `stops` stops on each branch. A branch that does not reach a share has no stop
/// there.
Branches trace_branches(const TunedPlant& plant, double max_K, int stops = 9);

}  // namespace smaservo::tune
