#pragma once
// What paper 001 drives its actuator with, and what ours answers.

#include <vector>

#include "model/duhem_actuator.hpp"

namespace smaservo {

/// A sinusoidal voltage of decreasing amplitude about a mean, as in 001 fig. 4: the paper prints no
/// numbers of it. These are chosen so that the first swing goes once around the major loop, as far
/// as the ambient temperature lets it, and later ones turn on the slopes of both sides.
struct DecayingVoltage {
  double mean_V;
  double amplitude_V;
  double decay_s;
  double period_s;
  double duration_s;

  double voltage_V(double time_s) const;
};
inline constexpr DecayingVoltage paper_001_voltage{1.52, 1.5, 150, 50, 350};

struct ActuatorSample {
  double time_s;
  double voltage_V;
  DuhemActuator<double>::Output output;
};

/// From rest, in steps of 10 ms, a sample every 100 ms.
std::vector<ActuatorSample> run_actuator(const DuhemActuator<double>::Params& params,
                                         const DecayingVoltage& voltage);

}  // namespace smaservo
