#pragma once
// The model's parameters in another scalar.

#include "model/plant.hpp"
#include "model/wire.hpp"

namespace smaservo::bench {

/// A number that is known only at run time.
template <class To>
To number(double x) {
  if constexpr (requires { To::of(x); }) {
    return To::of(x);
  } else {
    return static_cast<To>(x);
  }
}

template <class To>
Material<To> convert(const Material<double>& from) {
  const auto phase = [](const Phase<double>& p) {
    return Phase<To>{number<To>(p.strain), number<To>(p.modulus_Pa),
                     number<To>(p.resistivity_ohm_m), number<To>(p.resistivity_ohm_m_K),
                     number<To>(p.resistivity_ohm_m_Pa)};
  };
  return {phase(from.martensite), phase(from.r_phase), phase(from.austenite),
          number<To>(from.reference_K), from.mixture};
}

template <class To>
typename ThreePhase<To>::Params convert(const ThreePhase<double>::Params& from) {
  const auto surface = [](const auto& s) {
    return convert_surface<To>(s, [](double c) { return number<To>(c); });
  };
  return {surface(from.m2a),
          convert_surface<Pair<To>>(from.a2m_a2r,
                                    [](const Pair<double>& c) {
                                      return Pair<To>(number<To>(c.first()),
                                                      number<To>(c.second()));
                                    }),
          surface(from.r2a),
          surface(from.r2m),
          from.separate_r2a,
          from.separate_r2m,
          from.memory,
          number<To>(from.smallest_reversal_K)};
}

template <class To>
typename Plant<ThreePhase<To>>::Params convert(const Plant<ThreePhase<double>>::Params& from) {
  const ThermalBody<double>& body = from.body;
  const ColdEnds<double>& ends = from.ends;
  return {convert<To>(from.kinetics),
          convert<To>(from.material),
          {number<To>(body.capacity_J_K), number<To>(body.latent_m2a_J),
           number<To>(body.latent_r2a_J), number<To>(body.loss_W_K),
           number<To>(body.loss_W_K2)},
          {number<To>(ends.share),
           {number<To>(ends.phases.martensite), number<To>(ends.phases.r_phase)}},
          number<To>(from.length_per_area_1_m)};
}

template <class To>
Wire<To> convert(const Wire<double>& from) {
  const auto to = [](double value) { return number<To>(value); };
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

}  // namespace smaservo::bench
