#pragma once
// A wire as parallel sublayers, each with thresholds of its own between its phases.
// Source: the model of Müller, Achenbach and Seelecke (Achenbach 1989, 'A model for an alloy with
// shape memory'; Seelecke and Müller 2004, 'Shape memory alloy actuators in smart structures') in
// the limit of fast rates, where every layer is a play operator: the Preisach class, as paper
// 003's. The R-phase and its rules are ours. The model shares neither the curves nor the memory of
// the three-phase model, which it is there to test.
//
// Layer i consists of the martensite fraction m and of q, the R-phase's share of what is left:
//
//   m <- max(L, min(U, m))   L rises from 0 to 1 over `ramp_K` below a2m_K[i], on cooling
//   q <- max(L, min(U, q))   U falls from 1 to 0 over `ramp_K` above m2a_K[i], on heating
//                            the same for q with a2r_K[i] and r2a_K[i]
//
// Martensite takes from austenite and R-phase as they are; it never becomes R-phase, because a
// layer's R-phase has gone (r2a_K[i] + ramp_K <= m2a_K[i]) before its martensite goes.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

#include "model/kinetics.hpp"

namespace smaservo {

/// How one process' thresholds are distributed over the layers, and what stress does to them.
struct ThresholdSpread {
  double median_K;          ///< without stress
  double below_K, above_K;  ///< logistic scale on either side of the median, both > 0
  double per_Pa, per_Pa2;   ///< stress shifts all of them: per_Pa σ + per_Pa2 σ²
};

/// A wire's sublayers in a few numbers. r2a.per_Pa and per_Pa2 must not exceed m2a's.
struct SublayerSpread {
  ThresholdSpread m2a, a2m, r2a, a2r;
  double m_correlation;  ///< of a layer's ranks in m2a and a2m, -1..1; r2a ranks as m2a
  double r_correlation;  ///< of its ranks in a2m and a2r, -1..1
  double ramp_K;         ///< over which one layer converts, > 0
  std::uint64_t seed;    ///< of the ranks; the thresholds themselves are the quantiles
};

template <class S, std::size_t layers = 40>
struct Sublayers {
  using Scalar = S;
  using PerLayer = std::array<S, layers>;

  /// T begins to convert at threshold + per_Pa σ + per_Pa2 σ².
  struct Thresholds {
    PerLayer at_K;
    S per_Pa, per_Pa2;

    constexpr S shift_K(const S& stress_Pa) const {
      return stress_Pa * (per_Pa + stress_Pa * per_Pa2);
    }
  };

  struct Params {
    Thresholds m2a, a2m, r2a, a2r;
    S ramp_K;
  };

  struct State {
    PerLayer martensite;    ///< m
    PerLayer r_phase_part;  ///< q
    Drive<S> drive;
    Phases<S> phases;  ///< of all layers together
  };

  /// Stratified quantiles: the same spread gives the same thresholds, in any order of the layers.
  /// Where a layer's thresholds would cross, the lower one gives way. Cost: layers² comparisons.
  static Params params(const SublayerSpread& spread) {
    std::mt19937_64 random(spread.seed);
    const double ramp_K = spread.ramp_K;
    std::array<double, layers> a2m_score, a2r_score;
    const auto mixed = [&](double share, double score) {
      return share * score + std::sqrt(1 - share * share) * logit(uniform(random));
    };
    for (std::size_t i = 0; i < layers; ++i) {
      a2m_score[i] = mixed(spread.m_correlation, logit(stratum(i)));
      a2r_score[i] = mixed(spread.r_correlation, a2m_score[i]);
    }
    Params p;
    for (std::size_t i = 0; i < layers; ++i) {
      const double m2a_K = quantile(spread.m2a, i);
      const double r2a_K = lower(quantile(spread.r2a, i), m2a_K - ramp_K);
      p.m2a.at_K[i] = S(m2a_K);
      p.r2a.at_K[i] = S(r2a_K);
      p.a2m.at_K[i] = S(lower(quantile(spread.a2m, rank(a2m_score, i)), m2a_K - ramp_K));
      p.a2r.at_K[i] = S(lower(quantile(spread.a2r, rank(a2r_score, i)), r2a_K));
    }
    const auto shift = [](const ThresholdSpread& from, Thresholds& to) {
      to.per_Pa = S(from.per_Pa);
      to.per_Pa2 = S(from.per_Pa2);
    };
    shift(spread.m2a, p.m2a);
    shift(spread.a2m, p.a2m);
    shift(spread.r2a, p.r2a);
    shift(spread.a2r, p.a2r);
    p.ramp_K = S(ramp_K);
    return p;
  }

  static State rest(const Params& p, const Drive<S>& u) {
    State s;
    s.martensite.fill(S(0));
    s.r_phase_part.fill(S(0));
    advance(p, s, u);
    return s;
  }

  /// Exact for any step on which temperature and stress push the same way. Cost: 20 flops a layer.
  static void advance(const Params& p, State& s, const Drive<S>& u) {
    const S per_K = S(1) / p.ramp_K;
    move(p.m2a, p.a2m, u, per_K, s.martensite);
    move(p.r2a, p.a2r, u, per_K, s.r_phase_part);
    s.drive = u;
    S martensite = S(0);
    S r_phase = S(0);
    for (std::size_t i = 0; i < layers; ++i) {
      martensite = martensite + s.martensite[i];
      r_phase = r_phase + (S(1) - s.martensite[i]) * s.r_phase_part[i];
    }
    s.phases = {martensite / S(layers), r_phase / S(layers)};
  }

  static Drive<S> drive(const State& s) { return s.drive; }
  static Phases<S> phases(const State& s) { return s.phases; }

  /// Of the layers that are on their ramps.
  static PhaseRates<S> rates(const Params& p, const State& s, Heading heading) {
    const S per_K = S(1) / p.ramp_K;
    PerLayer m_moves, q_moves;
    moving(p.m2a, p.a2m, s.drive, per_K, heading, s.martensite, m_moves);
    moving(p.r2a, p.a2r, s.drive, per_K, heading, s.r_phase_part, q_moves);
    S martensite = S(0);
    S r_phase = S(0);
    for (std::size_t i = 0; i < layers; ++i) {
      martensite = martensite + m_moves[i];
      r_phase = r_phase + (S(1) - s.martensite[i]) * q_moves[i] - s.r_phase_part[i] * m_moves[i];
    }
    const S scale = S(0) - per_K / S(layers);
    return {scale * martensite, scale * r_phase};
  }

 private:
  static double lower(double a, double b) { return a < b ? a : b; }
  static double logit(double u) { return std::log(u / (1 - u)); }
  static double stratum(std::size_t i) { return (static_cast<double>(i) + 0.5) / layers; }
  static double uniform(std::mt19937_64& random) {
    return (static_cast<double>(random() >> 11U) + 0.5) * 0x1p-53;
  }
  static double quantile(const ThresholdSpread& spread, std::size_t rank) {
    const double l = logit(stratum(rank));
    return spread.median_K + (l < 0 ? spread.below_K : spread.above_K) * l;
  }
  static std::size_t rank(const std::array<double, layers>& scores, std::size_t of) {
    std::size_t lower_ones = 0;
    for (const double score : scores) {
      lower_ones += score < scores[of] ? 1U : 0U;
    }
    return lower_ones;
  }

  static S ramp(const S& x) {
    const S above = x < S(0) ? S(0) : x;
    return S(1) < above ? S(1) : above;
  }
  /// L, the least that a layer has at T; U, the most.
  static S least(const S& threshold_K, const S& T, const S& per_K) {
    return ramp((threshold_K - T) * per_K);
  }
  static S most(const S& threshold_K, const S& T, const S& per_K) {
    return ramp(S(1) - (T - threshold_K) * per_K);
  }

  static void move(const Thresholds& heating, const Thresholds& cooling, const Drive<S>& u,
                   const S& per_K, PerLayer& fraction) {
    const S T_heating = u.temperature_K - heating.shift_K(u.stress_Pa);
    const S T_cooling = u.temperature_K - cooling.shift_K(u.stress_Pa);
    for (std::size_t i = 0; i < layers; ++i) {
      const S U = most(heating.at_K[i], T_heating, per_K);
      const S L = least(cooling.at_K[i], T_cooling, per_K);
      const S below = U < fraction[i] ? U : fraction[i];
      fraction[i] = below < L ? L : below;
    }
  }

  /// 1 for the layers that a small step in this heading moves, else 0.
  static void moving(const Thresholds& heating, const Thresholds& cooling, const Drive<S>& u,
                     const S& per_K, Heading heading, const PerLayer& fraction, PerLayer& moves) {
    const auto on_ramp = [](const S& x) { return S(0) < x && x < S(1); };
    if (heading == Heading::heating) {
      const S T = u.temperature_K - heating.shift_K(u.stress_Pa);
      for (std::size_t i = 0; i < layers; ++i) {
        const S U = most(heating.at_K[i], T, per_K);
        moves[i] = on_ramp(U) && !(fraction[i] < U) ? S(1) : S(0);
      }
    } else {
      const S T = u.temperature_K - cooling.shift_K(u.stress_Pa);
      for (std::size_t i = 0; i < layers; ++i) {
        const S L = least(cooling.at_K[i], T, per_K);
        moves[i] = on_ramp(L) && !(L < fraction[i]) ? S(1) : S(0);
      }
    }
  }
};

}  // namespace smaservo
