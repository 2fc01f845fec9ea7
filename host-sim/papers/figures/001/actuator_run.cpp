#include "host-sim/papers/figures/001/actuator_run.hpp"

#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <string>
#include <utility>

namespace smaservo::figures {

double DecayingVoltage::voltage_V(double time_s) const {
  return mean_V - amplitude_V * std::exp(-time_s / decay_s) *
                      std::cos(2 * std::numbers::pi * time_s / period_s);
}

std::vector<ActuatorSample> run_actuator(const papers::DuhemActuator<double>::Params& params,
                                         const DecayingVoltage& voltage) {
  using Model = papers::DuhemActuator<double>;
  constexpr double dt_s = 0.01;
  Model::State state = Model::rest(params);
  std::vector<ActuatorSample> samples;
  const int steps = static_cast<int>(std::lround(voltage.duration_s / dt_s));
  for (int i = 0; i <= steps; ++i) {
    if (i % 10 == 0) {
      samples.push_back({i * dt_s, voltage.voltage_V(i * dt_s), Model::output(params, state)});
    }
    const double middle_V = voltage.voltage_V((i + 0.5) * dt_s);
    Model::advance(params, state, papers::VoltageSource<double>{middle_V}, dt_s);
  }
  return samples;
}

std::vector<MinorLoop> minor_loops(const papers::Duhem<double>::Params& params) {
  using Model = papers::Duhem<double>;
  const double cold_K = params.a2m.centre_K - 4 * params.a2m.deviation_K;
  const double hot_K = params.m2a.centre_K + 3.5 * params.m2a.deviation_K;
  std::vector<MinorLoop> loops;
  for (const double austenite : {1.0, 0.75, 0.5, 0.25}) {
    double turn_K = cold_K;
    Model::State heating = Model::rest(params, {cold_K, 0});
    while (turn_K < hot_K && 1 - heating.martensite < austenite) {
      turn_K += 0.1;
      Model::advance(params, heating, {turn_K, 0});
    }
    MinorLoop loop;
    Model::State cooling = heating;
    for (double T = turn_K; T > cold_K; T -= 0.5) {
      Model::advance(params, cooling, {T, 0});
      loop.temperature_K.push_back(T);
      loop.cooling.push_back(1 - cooling.martensite);
    }
    // Heats again through the same temperatures.
    Model::State again = cooling;
    loop.heating.resize(loop.temperature_K.size());
    for (std::size_t i = loop.temperature_K.size(); i-- > 0;) {
      Model::advance(params, again, {loop.temperature_K[i], 0});
      loop.heating[i] = 1 - again.martensite;
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

papers::DuhemActuator<double>::Params printed_resistivity(
    papers::DuhemActuator<double>::Params params) {
  for (double& coefficient : params.resistivity.martensite_ohm_m_K) {
    coefficient = std::stod(fmt::format("{:.1e}", coefficient));
  }
  return params;
}

}  // namespace smaservo::figures
