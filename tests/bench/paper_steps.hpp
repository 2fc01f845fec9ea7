#pragma once
// The same for the models of the papers. In a unit of their own: beside them the compiler inlines
// less of the observer, by 5 % of its instructions.

#include <cmath>

#include "model/papers/duhem.hpp"
#include "model/papers/liang_rogers.hpp"
#include "model/papers/preisach.hpp"
#include "observer/papers/strain_resistance.hpp"
#include "tests/bench/steps.hpp"

namespace smaservo::benchmarks {

/// The same temperatures as Gaussians: four deviations from start to finish.
template <class S>
typename papers::Duhem<S>::Params duhem_params() {
  const typename papers::Cosine<S>::Params p = cosine_params<S>();
  const auto process = [](const papers::CosineProcess<S>& c) {
    return typename papers::Duhem<S>::Process{S(0.5) * (c.start_K + c.finish_K),
                                              S(0.25) * std::abs(c.finish_K - c.start_K),
                                              S(1) / c.stress_Pa_K};
  };
  return {process(p.m2a), process(p.a2m)};
}

/// With an R-phase that begins 8 K above the martensite.
template <class S>
typename papers::LiangRogers<S>::Params liang_rogers_params() {
  const typename papers::Cosine<S>::Params p = cosine_params<S>();
  papers::CosineProcess<S> a2r = p.a2m;
  a2r.start_K += S(8);
  a2r.finish_K += S(8);
  return {p.m2a, p.a2m, a2r};
}

/// Relays spread evenly over 20 to 110 °C, the same at three stresses.
template <class S>
typename papers::Preisach<S>::Params preisach_params() {
  typename papers::Preisach<S>::Params p{};
  const std::size_t last = p.node_K.size() - 1;
  const auto share = [&](std::size_t i) { return static_cast<S>(i) / static_cast<S>(last); };
  for (std::size_t i = 0; i <= last; ++i) {
    p.node_K[i] = S(293.15) + S(90) * share(i);
  }
  p.stress_count = 3;
  for (std::size_t k = 0; k < p.stress_count; ++k) {
    p.stress_Pa[k] = S(100e6) + S(50e6) * static_cast<S>(k);
    for (std::size_t hot = 1; hot <= last; ++hot) {
      for (std::size_t cold = 0; cold < hot; ++cold) {
        p.increments[k][p.index(hot, cold)] = share(hot - cold) * share(hot - cold);
      }
    }
  }
  return p;
}

/// Two lines some tenths of a per cent apart, about as a wire of 76 um has them at 150 MPa.
template <class S>
typename papers::StrainResistance<S>::Params strain_resistance_params() {
  typename papers::StrainResistance<S>::Params p{};
  p.martensite_ohm = measurements<S>().front().resistance_ohm;
  p.min_stress_Pa = S(100e6);
  p.max_stress_Pa = S(200e6);
  p.heating = {{{S(0.25), S(0.03)}}, {{S(-0.22), S(-0.02)}}};
  p.cooling = {{{S(0.27), S(0.02)}}, {{S(-0.245), S(-0.015)}}};
  p.initial_slope = S(0.05);
  p.decay = S(200);
  p.smallest_reversal = S(2e-4);
  p.strain_sd = S(1e-3);
  return p;
}

template <class S, class F>
void for_each_paper_step(F f) {
  f("duhem_step", [] { return KineticsStep<papers::Duhem<S>>(duhem_params<S>(), triangle<S>(0)); });
  f("liang_rogers_step",
    [] { return KineticsStep<papers::LiangRogers<S>>(liang_rogers_params<S>(), triangle<S>(0)); });
  f("preisach_step",
    [] { return KineticsStep<papers::Preisach<S>>(preisach_params<S>(), triangle<S>(0)); });
  f("preisach_step_varying_stress",
    [] { return KineticsStep<papers::Preisach<S>>(preisach_params<S>(), triangle<S>(100e6)); });
  f("strain_resistance_step",
    [] { return ObserverStep<papers::StrainResistance<S>>(strain_resistance_params<S>()); });
}

}  // namespace smaservo::benchmarks
