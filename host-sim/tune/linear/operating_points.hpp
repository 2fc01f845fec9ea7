#pragma once
// A wire under its load, linearised along both branches of its hysteresis: from power to
// temperature, and from temperature to each variable that a loop controls.

#include <string>
#include <vector>

#include "model/wire/plant.hpp"

namespace smaservo::tune {

/// A constant load (stroke 0), or a spring: a straight line from the stress in the wire at rest to
/// that in a wire shorter by `stroke`.
struct TunedLoad {
  double low_Pa, high_Pa;
  double stroke;

  bool is_spring() const { return stroke > 0; }
  /// The stress in a wire that is shorter than at rest by the strain `shorter`.
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

/// Makes one step of a wire with its load, which moves along without mass; returns the stress after
/// it.
double advance_loaded(const TunedPlant& plant, const LumpedModel::Params& params,
                      LumpedModel::State& state, double power_W, double rest_strain, double dt_s);

enum class Motion : unsigned char {
  heating,  ///< the wire contracts
  cooling,  ///< the wire stretches
  turned,   ///< between the branches: the wire has reversed, and keeps its strain
};
std::string motion_name(Motion motion);

/// A wire in motion. C dT/dt = P - loss; everything else follows the temperature without delay.
struct OperatingPoint {
  Motion motion;
  double share;  ///< contraction as a share of the stroke
  LumpedModel::State state;
  double stress_Pa, strain, ohm, temperature_K;
  double capacity_J_K;  ///< including latent heat and the effect of the load's stress
  double loss_W, loss_slope_W_K;
  double strain_1_K, ohm_1_K,
      /// Slopes over temperature, with the load following the strain.
      load_N_K;
};

struct Branches {
  double rest_strain;  ///< strain of the cold wire at ambient temperature
  double hot_strain;   ///< least strain that the limits allow
  double hottest_K;    ///< temperature at hot_strain
  double hot_Pa;       ///< stress at hot_strain
  double min_ohm, max_ohm;
  double heat_J;     ///< heat for the whole stroke from rest, without losses
  double cooling_s;  ///< time from 90 % to 10 % of the stroke without current
  double fastest_cooling_1_s;
  /// Points of each branch at equal shares, and three in the state `turned`.
  std::vector<OperatingPoint> points;

  double stroke() const { return rest_strain - hot_strain; }
};

/// Traces a full cycle from rest, up to 12 K beyond the transformation or to `max_K`, in steps of
/// 0.02 K, with `stops` stops on each branch. A branch that does not reach a share has no stop
/// there.
Branches trace_branches(const TunedPlant& plant, double max_K, int stops = 9);

}  // namespace smaservo::tune
