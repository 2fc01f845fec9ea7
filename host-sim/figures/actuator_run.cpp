#include "host-sim/figures/actuator_run.hpp"

#include <cmath>
#include <numbers>

namespace smaservo {

double DecayingVoltage::voltage_V(double time_s) const {
  return mean_V - amplitude_V * std::exp(-time_s / decay_s) *
                      std::cos(2 * std::numbers::pi * time_s / period_s);
}

std::vector<ActuatorSample> run_actuator(const DuhemActuator<double>::Params& params,
                                         const DecayingVoltage& voltage) {
  using Model = DuhemActuator<double>;
  constexpr double dt_s = 0.01;
  Model::State state = Model::rest(params);
  std::vector<ActuatorSample> samples;
  const int steps = static_cast<int>(std::lround(voltage.duration_s / dt_s));
  for (int i = 0; i <= steps; ++i) {
    if (i % 10 == 0) {
      samples.push_back({i * dt_s, voltage.voltage_V(i * dt_s), Model::output(params, state)});
    }
    const double middle_V = voltage.voltage_V((i + 0.5) * dt_s);
    Model::advance(params, state, VoltageSource<double>{middle_V}, dt_s);
  }
  return samples;
}

}  // namespace smaservo
