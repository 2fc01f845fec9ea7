#pragma once
// Wires and models that several tests share.

#include "model/files/wire/wire_file.hpp"
#include "model/papers/cosine.hpp"
#include "model/papers/duhem.hpp"
#include "model/papers/liang_rogers.hpp"
#include "model/units.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::test {

inline constexpr double MPa = 1e6;

/// The 76 um wire of paper 000.
inline const Wire<double>& paper_wire() {
  static const Wire<double> wire = files::load_wire("smartflex-76um").wire;
  return wire;
}

/// Its kinetics with the paper's scaling: no memory, every reversal counts.
inline ThreePhase<double>::Params plain_kinetics() {
  ThreePhase<double>::Params p = paper_wire().kinetics;
  p.memory = Memory::plain;
  p.smallest_reversal_K = 0;
  return p;
}

/// R2M and R2A with surfaces of their own, several kelvin away from A2M's and M2A's.
inline ThreePhase<double>::Params separate_kinetics() {
  ThreePhase<double>::Params p = paper_wire().kinetics;
  p.separate_r2a = true;
  p.r2a = {{zero_degC_K + 66, 0.12 / MPa, 0}, {zero_degC_K + 71, 0.13 / MPa, 0}, {3, 0}, {0.5, 0}};
  p.separate_r2m = true;
  p.r2m = {{zero_degC_K + 48, 0.13 / MPa, 0}, {zero_degC_K + 39, 0.13 / MPa, 0}, {3, 0}, {0.45, 0}};
  return p;
}

/// What became martensite last goes back first, mostly, and the curves end sooner than in 000.
inline ThreePhase<double>::Params ordered_kinetics() {
  ThreePhase<double>::Params p = paper_wire().kinetics;
  p.loop_odds = 8;
  p.m2a.taper = 0.5;
  p.a2m_a2r.taper = Pair<double>(1, 0.2);
  return p;
}

/// Its temperatures are `factor` times as far above room_K.
inline Surface<double> warmed(Surface<double> surface, double factor) {
  for (double(*kelvin)[3] : {&surface.start_K, &surface.finish_K}) {
    (*kelvin)[0] = room_K + factor * ((*kelvin)[0] - room_K);
    (*kelvin)[1] *= factor;
    (*kelvin)[2] *= factor;
  }
  return surface;
}

/// A wire that the same power heats `factor` times as far above room_K, and that has the same
/// resistance and strain then.
inline Wire<double> warmed(Wire<double> wire, double factor) {
  ThreePhaseParams<double>& kinetics = wire.kinetics;
  kinetics.m2a = warmed(kinetics.m2a, factor);
  kinetics.r2a = warmed(kinetics.r2a, factor);
  kinetics.r2m = warmed(kinetics.r2m, factor);
  kinetics.a2m_a2r = pair_surfaces(warmed(first_surface(kinetics.a2m_a2r), factor),
                                   warmed(second_surface(kinetics.a2m_a2r), factor));
  kinetics.smallest_reversal_K *= factor;
  Material<double>& material = wire.material;
  material.reference_K = room_K + factor * (material.reference_K - room_K);
  for (Phase<double>* phase : {&material.martensite, &material.r_phase, &material.austenite}) {
    phase->resistivity_ohm_m_K /= factor;
  }
  HeatParams<double>& heat = wire.heat;
  heat.specific_heat_J_kgK /= factor;
  heat.convection_W_m2K /= factor;
  heat.convection_W_m2K2 /= factor * factor;
  heat.clamp_conductivity_W_mK /= factor;
  return wire;
}

/// The same parameters for another scalar.
template <class S>
typename ThreePhase<S>::Params kinetics_for(const ThreePhase<double>::Params& from) {
  const auto cast = [](double value) { return S(value); };
  const auto surface = [&](const Surface<double>& s) { return convert_surface<S>(s, cast); };
  typename ThreePhase<S>::Params to{};
  to.m2a = surface(from.m2a);
  to.a2m_a2r =
      pair_surfaces(surface(first_surface(from.a2m_a2r)), surface(second_surface(from.a2m_a2r)));
  to.r2a = surface(from.r2a);
  to.r2m = surface(from.r2m);
  to.separate_r2a = from.separate_r2a;
  to.separate_r2m = from.separate_r2m;
  to.memory = from.memory;
  to.smallest_reversal_K = S(from.smallest_reversal_K);
  to.loop_odds = S(from.loop_odds);
  return to;
}

/// The makers' transition temperatures of the Flexinol LT alloy, slopes as usual for it.
template <class S>
typename papers::Cosine<S>::Params flexinol_cosine() {
  const auto K = [](double celsius) { return S(celsius + zero_degC_K); };
  return {{K(68), K(78), S(8e6)}, {K(52), K(42), S(7e6)}};
}

/// The same alloy as Gaussians: start and finish two deviations from the centre, roughly.
template <class S>
typename papers::Duhem<S>::Params flexinol_duhem() {
  const auto K = [](double celsius) { return S(celsius + zero_degC_K); };
  return {{K(73), S(3), S(1 / 8e6)}, {K(47), S(2.5), S(1 / 7e6)}};
}

/// The same with an R-phase; its slope is that of the B2-R transformation in many NiTi alloys.
template <class S>
typename papers::LiangRogers<S>::Params flexinol_liang_rogers() {
  const typename papers::Cosine<S>::Params two = flexinol_cosine<S>();
  return {two.m2a, two.a2m, {S(64 + zero_degC_K), S(59 + zero_degC_K), S(15e6)}};
}

}  // namespace smaservo::test
