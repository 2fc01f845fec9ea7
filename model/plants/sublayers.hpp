#pragma once
// A wire as parallel sublayers, each with its own thresholds between its phases.
// Source: the model of Müller, Achenbach and Seelecke (Achenbach 1989, 'A model for an alloy with
// shape memory'; Seelecke and Müller 2004, 'Shape memory alloy actuators in smart structures') in
// the limit of fast rates, where every layer is a play operator: the Preisach class, like the model
// of paper 003. The R-phase and its rules are ours. The model shares neither the curves nor the
// memory of the three-phase model, which it serves to test.
//
// Layer i consists of the martensite fraction m and of q, the R-phase's share of the rest:
//
//   m <- max(L, min(U, m))   L rises from 0 to 1 over `ramp_K` below a2m_K[i], on cooling
//   q <- max(L, min(U, q))   U falls from 1 to 0 over `ramp_K` above m2a_K[i], on heating
//                            the same for q with a2r_K[i] and r2a_K[i]
//
// Martensite grows from austenite and R-phase in proportion; it never becomes R-phase, because a
// layer's R-phase has vanished (r2a_K[i] + ramp_K <= m2a_K[i]) before its martensite begins to.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

#include "model/kinetics.hpp"
#include "model/plants/threshold_spread.hpp"
#include "model/scalar/order.hpp"

namespace smaservo {

/// A few numbers that describe the sublayers. r2a.per_Pa and per_Pa2 must not exceed m2a's.
struct SublayerSpread {
  ThresholdSpread m2a, a2m, r2a, a2r;
  double m_correlation;  ///< correlation of a layer's ranks in m2a and a2m, -1..1; r2a ranks as m2a
  double r_correlation;  ///< correlation of its ranks in a2m and a2r, -1..1
  double ramp_K;         ///< temperature range over which one layer converts, > 0
  std::uint64_t seed;    ///< random seed of the ranks; the thresholds are the quantiles
};

template <class S, std::size_t layers = 40>
struct Sublayers {
  using Scalar = S;
  static_assert(layers % 4 == 0 && layers < 256);
  using PerLayer = std::array<S, layers>;

  /// A layer begins to convert at the temperature threshold + per_Pa σ + per_Pa2 σ².
  struct Thresholds {
    PerLayer at_K;
    PerLayer sorted_K;                       ///< at_K in rising order
    std::array<std::uint8_t, layers> layer;  ///< index of the layer that each sorted_K belongs to
    S per_Pa, per_Pa2;

    /// The temperature less the shift by the stress.
    constexpr S felt_K(const Drive<S>& u) const {
      return u.temperature_K - u.stress_Pa * (per_Pa + u.stress_Pa * per_Pa2);
    }
  };

  struct Params {
    Thresholds m2a, a2m, r2a, a2r;
    S ramp_K;
    /// How far stress may shift A2M above M2A, and A2R above R2A, before L and U of a layer meet.
    S m_apart_K, r_apart_K;
  };

  /// The number of thresholds that the wire has passed, for heating and for cooling.
  struct Place {
    std::uint8_t heating, cooling;
  };

  struct State {
    PerLayer martensite;    ///< m
    PerLayer r_phase_part;  ///< q
    Place m_place, r_place;
    Drive<S> drive;
    Phases<S> phases;  ///< means of all layers
  };

  /// Stratified quantiles: the same spread gives the same thresholds, up to the order of the
  /// layers. If a layer's thresholds would cross, the lower one is moved down. Cost: layers²
  /// comparisons.
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
    const auto finish = [](const ThresholdSpread& from, Thresholds& to) {
      to.per_Pa = S(from.per_Pa);
      to.per_Pa2 = S(from.per_Pa2);
      for (std::size_t i = 0; i < layers; ++i) {
        to.layer[i] = static_cast<std::uint8_t>(i);
      }
      std::ranges::sort(to.layer, {}, [&](std::uint8_t i) { return to.at_K[i]; });
      std::ranges::transform(to.layer, to.sorted_K.begin(),
                             [&](std::uint8_t i) { return to.at_K[i]; });
    };
    finish(spread.m2a, p.m2a);
    finish(spread.a2m, p.a2m);
    finish(spread.r2a, p.r2a);
    finish(spread.a2r, p.a2r);
    p.ramp_K = S(ramp_K);
    p.m_apart_K = apart_K(p.m2a, p.a2m, p.ramp_K);
    p.r_apart_K = apart_K(p.r2a, p.a2r, p.ramp_K);
    return p;
  }

  static State rest(const Params& p, const Drive<S>& u) {
    State s;
    s.martensite.fill(S(0));
    s.r_phase_part.fill(S(0));
    s.m_place = {layers, layers};
    s.r_place = {layers, layers};
    s.drive = {S(1e4), u.stress_Pa};
    s.phases = {S(0), S(0)};
    advance(p, s, u);
    return s;
  }

  /// Exact for any step on which temperature and stress push in the same direction. Cost: 15 flops
  /// for each layer on its ramp, and 4 per layer for the sums.
  static void advance(const Params& p, State& s, const Drive<S>& u) {
    const bool m = move(p.m2a, p.a2m, p.m_apart_K, p.ramp_K, s.drive, u, s.m_place, s.martensite);
    const bool q = move(p.r2a, p.a2r, p.r_apart_K, p.ramp_K, s.drive, u, s.r_place, s.r_phase_part);
    s.drive = u;
    if (m || q) {
      s.phases = {mean([&](std::size_t i) { return s.martensite[i]; }), mean([&](std::size_t i) {
                    return (S(1) - s.martensite[i]) * s.r_phase_part[i];
                  })};
    }
  }

  static Drive<S> drive(const State& s) { return s.drive; }
  static Phases<S> phases(const State& s) { return s.phases; }

  /// The slopes of the layers that are on their ramps.
  static PhaseRates<S> rates(const Params& p, const State& s, Heading heading) {
    S martensite = S(0);
    S r_phase = S(0);
    const auto moves_m = [&](std::size_t i) {
      martensite += S(1);
      r_phase -= s.r_phase_part[i];
    };
    const auto moves_q = [&](std::size_t i) { r_phase += S(1) - s.martensite[i]; };
    if (heading == Heading::heating) {
      for_each_falling(p.m2a, s.drive, p.ramp_K, s.m_place, s.martensite, moves_m);
      for_each_falling(p.r2a, s.drive, p.ramp_K, s.r_place, s.r_phase_part, moves_q);
    } else {
      for_each_rising(p.a2m, s.drive, p.ramp_K, s.m_place, s.martensite, moves_m);
      for_each_rising(p.a2r, s.drive, p.ramp_K, s.r_place, s.r_phase_part, moves_q);
    }
    const S scale = S(-1) / (p.ramp_K * S(layers));
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

  /// The least distance of a layer's two thresholds, plus half of the ramp. L and U would meet at
  /// the whole ramp; the other half keeps rounding from mattering.
  static S apart_K(const Thresholds& heating, const Thresholds& cooling, const S& ramp_K) {
    S min_K = heating.at_K[0] - cooling.at_K[0];
    for (std::size_t i = 1; i < layers; ++i) {
      const S gap_K = heating.at_K[i] - cooling.at_K[i];
      min_K = gap_K < min_K ? gap_K : min_K;
    }
    return min_K + S(0.5) * ramp_K;
  }

  /// The mean of of(i) over all layers, in four independent sums that need not wait for each other.
  template <class F>
  static S mean(F of) {
    S sum[4] = {of(0), of(1), of(2), of(3)};
    for (std::size_t i = 4; i < layers; i += 4) {
      for (std::size_t lane = 0; lane < 4; ++lane) {
        sum[lane] += of(i + lane);
      }
    }
    return ((sum[0] + sum[2]) + (sum[1] + sum[3])) / S(layers);
  }

  /// The number of thresholds below T, searched from a place nearby.
  static std::uint8_t below(const PerLayer& sorted_K, const S& T, std::uint8_t place) {
    while (place < layers && sorted_K[place] < T) {
      ++place;
    }
    while (place > 0 && !(sorted_K[place - 1U] < T)) {
      --place;
    }
    return place;
  }

  // Bounds of a layer's fraction at T before they are clamped to 0..1: the least, L, and the
  // greatest, U.
  static S min(const S& threshold_K, const S& T, const S& per_K) {
    return (threshold_K - T) * per_K;
  }
  static S max(const S& threshold_K, const S& T, const S& per_K) {
    return S(1) - (T - threshold_K) * per_K;
  }

  /// Visits the layers that U or L can have moved: from the threshold that T has now reached back
  /// to those whose ramp was complete before the step. If L may exceed U in a layer, all layers are
  /// visited and both bounds apply.
  static bool move(const Thresholds& heating, const Thresholds& cooling, const S& apart_K,
                   const S& ramp_K, const Drive<S>& from, const Drive<S>& to, Place& place,
                   PerLayer& fraction) {
    const S per_K = S(1) / ramp_K;
    const S hot_from = heating.felt_K(from);
    const S hot_to = heating.felt_K(to);
    const S cold_from = cooling.felt_K(from);
    const S cold_to = cooling.felt_K(to);
    const bool apart = hot_from - cold_from < apart_K && hot_to - cold_to < apart_K;
    place = {below(heating.sorted_K, hot_to, place.heating),
             below(cooling.sorted_K, cold_to, place.cooling)};
    bool moved = false;
    if (!apart || hot_from < hot_to) {
      for (std::size_t k = place.heating; k-- > 0;) {
        const S U = positive(max(heating.sorted_K[k], hot_to, per_K));
        S& x = fraction[heating.layer[k]];
        moved = moved || U < x;
        x = U < x ? U : x;
        if (apart && !(S(0) < max(heating.sorted_K[k], hot_from, per_K))) {
          break;
        }
      }
    }
    if (!apart || cold_to < cold_from) {
      for (std::size_t k = place.cooling; k < layers; ++k) {
        const S L = at_most_1(min(cooling.sorted_K[k], cold_to, per_K));
        S& x = fraction[cooling.layer[k]];
        moved = moved || x < L;
        x = x < L ? L : x;
        if (apart && !(min(cooling.sorted_K[k], cold_from, per_K) < S(1))) {
          break;
        }
      }
    }
    return moved;
  }
  static S at_most_1(const S& x) { return S(1) < x ? S(1) : x; }

  /// Calls f(layer) for the layers that a small step of heating moves (for_each_rising: of
  /// cooling).
  template <class F>
  static void for_each_falling(const Thresholds& heating, const Drive<S>& u, const S& ramp_K,
                               const Place& place, const PerLayer& fraction, F f) {
    const S per_K = S(1) / ramp_K;
    const S T = heating.felt_K(u);
    for (std::size_t k = place.heating; k-- > 0;) {
      const S U = max(heating.sorted_K[k], T, per_K);
      if (!(S(0) < U)) {
        break;
      }
      const std::size_t i = heating.layer[k];
      if (U < S(1) && !(fraction[i] < U)) {
        f(i);
      }
    }
  }
  template <class F>
  static void for_each_rising(const Thresholds& cooling, const Drive<S>& u, const S& ramp_K,
                              const Place& place, const PerLayer& fraction, F f) {
    const S per_K = S(1) / ramp_K;
    const S T = cooling.felt_K(u);
    for (std::size_t k = place.cooling; k < layers; ++k) {
      const S L = min(cooling.sorted_K[k], T, per_K);
      if (!(L < S(1))) {
        break;
      }
      const std::size_t i = cooling.layer[k];
      if (S(0) < L && !(L < fraction[i])) {
        f(i);
      }
    }
  }
};

}  // namespace smaservo
