#pragma once
// The voltage that drives the actuator of paper 001, and the model's response.

#include <vector>

#include "model/papers/duhem_actuator.hpp"

namespace smaservo::figures {

/// A sinusoidal voltage of decreasing amplitude about a mean, as in 001 fig. 4, for which the paper
/// gives no numbers. These numbers are chosen so that the first oscillation goes once around the
/// major loop, as far as the ambient temperature allows, and later ones reverse on the slopes of
/// both sides.
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
  papers::DuhemActuator<double>::Output output;
};

/// Runs the actuator from rest in steps of 10 ms; returns a sample every 100 ms.
std::vector<ActuatorSample> run_actuator(const papers::DuhemActuator<double>::Params& params,
                                         const DecayingVoltage& voltage);

/// Austenite in one loop: heating from cold to the turning point, and cooling from there.
struct MinorLoop {
  std::vector<double> temperature_K;
  std::vector<double> heating, cooling;
};

/// The major loop, then loops that reverse at three quarters, half and a quarter of austenite: 001
/// fig. 7. The heating of a minor loop begins where its cooling has ended.
std::vector<MinorLoop> minor_loops(const papers::Duhem<double>::Params& params);

/// The parameters with the coefficients of martensite's resistivity rounded to the two digits of
/// Table I.
papers::DuhemActuator<double>::Params printed_resistivity(
    papers::DuhemActuator<double>::Params params);

}  // namespace smaservo::figures
