#pragma once
// Strain as a straight line over resistance, from cold martensite to hot austenite at the present
// stress, without hysteresis, heat or R-phase: the usual way to sense wires. A reference for
// comparison.

#include "model/wire/plant.hpp"
#include "observer/estimate.hpp"

namespace smaservo {

template <class S>
struct LineObserver {
  using Scalar = S;

  struct Params {
    typename Plant<ThreePhase<S>>::Params model;
  };

  struct State {
    S ambient_K;
    S stress_Pa;
    S martensite;  ///< share of the way from austenite to martensite
  };

  static State start(const Params& p, const Measurement<S>& m, const S& ambient_K) {
    State s{ambient_K, m.stress_Pa, S(1)};
    advance(p, s, m, S(0));
    return s;
  }

  static void advance(const Params& p, State& s, const Measurement<S>& m, const S& /*dt_s*/) {
    if (m.stress_valid) {
      s.stress_Pa = m.stress_Pa;
    }
    if (!m.resistance_valid) {
      return;
    }
    const S hot_ohm = ohm(p, s, S(0));
    const S share = (m.resistance_ohm - hot_ohm) / (ohm(p, s, S(1)) - hot_ohm);
    s.martensite = share < S(0) ? S(0) : S(1) < share ? S(1) : share;
  }

  static Estimate<S> estimate(const Params& p, const State& s) {
    return {strain(p.model.material, Phases<S>{s.martensite, S(0)}, s.stress_Pa),
            S(0),
            temperature_K(p, s, s.martensite),
            s.martensite,
            S(0),
            ohm(p, s, s.martensite),
            Health::good};
  }

  /// The inverse of the line: the resistance for a strain, at the stress and ambient temperature of
  /// `s`.
  static S resistance_ohm(const Params& p, const State& s, const S& strain) {
    const S austenite = smaservo::strain(p.model.material, Phases<S>{S(0), S(0)}, s.stress_Pa);
    const S martensite = smaservo::strain(p.model.material, Phases<S>{S(1), S(0)}, s.stress_Pa);
    const S share = (strain - austenite) / (martensite - austenite);
    const S hot_ohm = ohm(p, s, S(0));
    return hot_ohm + share * (ohm(p, s, S(1)) - hot_ohm);
  }

 private:
  static S temperature_K(const Params& p, const State& s, const S& martensite) {
    const Isobar<S> m2a = isobar(p.model.kinetics.m2a, s.stress_Pa);
    const S hot_K = m2a.start_K + S(1) / m2a.per_K;
    return hot_K + martensite * (s.ambient_K - hot_K);
  }
  static S ohm(const Params& p, const State& s, const S& martensite) {
    const Phases<S> z{martensite, S(0)};
    const Drive<S> u{temperature_K(p, s, martensite), s.stress_Pa};
    return smaservo::resistance_ohm(resistivity(p.model.material, z, u).value,
                                    p.model.length_per_area_1_m,
                                    strain(p.model.material, z, s.stress_Pa));
  }
};

}  // namespace smaservo
