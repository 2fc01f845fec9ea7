#pragma once
// The model's parameters in another scalar.

#include "model/scalar/scalar.hpp"
#include "model/wire/plant.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::benchmarks {

template <class To>
Material<To> convert(const Material<double>& from) {
  const auto phase = [](const Phase<double>& p) {
    return Phase<To>{scalar<To>(p.strain), scalar<To>(p.modulus_Pa),
                     scalar<To>(p.resistivity_ohm_m), scalar<To>(p.resistivity_ohm_m_K),
                     scalar<To>(p.resistivity_ohm_m_Pa)};
  };
  return {phase(from.martensite), phase(from.r_phase), phase(from.austenite),
          scalar<To>(from.reference_K), from.mixture};
}

template <class To>
typename ThreePhase<To>::Params convert(const ThreePhase<double>::Params& from) {
  const auto surface = [](const auto& s) {
    return convert_surface<To>(s, [](double c) { return scalar<To>(c); });
  };
  return {surface(from.m2a),
          convert_surface<Pair<To>>(from.a2m_a2r,
                                    [](const Pair<double>& c) {
                                      return Pair<To>(scalar<To>(c.first()),
                                                      scalar<To>(c.second()));
                                    }),
          surface(from.r2a),
          surface(from.r2m),
          from.separate_r2a,
          from.separate_r2m,
          from.memory,
          scalar<To>(from.smallest_reversal_K),
          scalar<To>(from.loop_odds)};
}

template <class To>
typename Plant<ThreePhase<To>>::Params convert(const Plant<ThreePhase<double>>::Params& from) {
  const ThermalBody<double>& body = from.body;
  const ColdEnds<double>& ends = from.ends;
  return {convert<To>(from.kinetics),
          convert<To>(from.material),
          {scalar<To>(body.capacity_J_K), scalar<To>(body.latent_m2a_J),
           scalar<To>(body.latent_r2a_J), scalar<To>(body.loss_W_K), scalar<To>(body.loss_W_K2)},
          {scalar<To>(ends.share),
           {scalar<To>(ends.phases.martensite), scalar<To>(ends.phases.r_phase)}},
          scalar<To>(from.length_per_area_1_m)};
}

template <class To>
Wire<To> convert(const Wire<double>& from) {
  const auto to = [](double value) { return scalar<To>(value); };
  const HeatParams<double>& heat = from.heat;
  return {{to(from.geometry.length_m), to(from.geometry.diameter_m)},
          {to(from.limits.current_A), to(from.limits.stress_Pa), to(from.limits.temperature_K)},
          to(from.nominal_stroke),
          convert<To>(from.kinetics),
          convert<To>(from.material),
          {to(heat.density_kg_m3), to(heat.specific_heat_J_kgK), to(heat.latent_m2a_J_kg),
           to(heat.latent_r2a_J_kg), to(heat.convection_W_m2K), to(heat.convection_W_m2K2),
           to(heat.clamp_conductivity_W_mK)},
          {to(from.accuracy.strain), to(from.accuracy.resistance)}};
}

}  // namespace smaservo::benchmarks
