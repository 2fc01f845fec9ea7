#pragma once
// The parameters of a filter in single precision.

#include "observer/kalman.hpp"

namespace smaservo {

inline Surface<float> to_float(const Surface<double>& s) {
  return convert_surface<float>(s, [](double x) { return static_cast<float>(x); });
}
inline Phase<float> to_float(const Phase<double>& p) {
  return {static_cast<float>(p.strain), static_cast<float>(p.modulus_Pa),
          static_cast<float>(p.resistivity_ohm_m), static_cast<float>(p.resistivity_ohm_m_K),
          static_cast<float>(p.resistivity_ohm_m_Pa)};
}

/// The tuning is that of the type.
inline KalmanObserver<float>::Params to_float(const KalmanObserver<double>::Params& p) {
  const auto f = [](double x) { return static_cast<float>(x); };
  const auto& m = p.model;
  const auto& k = m.kinetics;
  KalmanObserver<float>::Params to{};
  to.model.kinetics = {
      to_float(k.m2a),
      pair_surfaces(to_float(first_surface(k.a2m_a2r)), to_float(second_surface(k.a2m_a2r))),
      to_float(k.r2a),
      to_float(k.r2m),
      k.separate_r2a,
      k.separate_r2m,
      k.memory,
      f(k.smallest_reversal_K),
      f(k.loop_odds)};
  to.model.material = {to_float(m.material.martensite), to_float(m.material.r_phase),
                       to_float(m.material.austenite), f(m.material.reference_K),
                       m.material.mixture};
  to.model.body = {f(m.body.capacity_J_K), f(m.body.latent_m2a_J), f(m.body.latent_r2a_J),
                   f(m.body.loss_W_K), f(m.body.loss_W_K2)};
  to.model.ends = {f(m.ends.share), {f(m.ends.phases.martensite), f(m.ends.phases.r_phase)}};
  to.model.length_per_area_1_m = f(m.length_per_area_1_m);
  return to;
}

}  // namespace smaservo
