#pragma once
// A wire as parts that jump over energy barriers, each at rates of its own: transformation takes
// time, and goes on while temperature and load rest.
// Source: the model of Müller, Achenbach and Seelecke (Achenbach 1989, 'A model for an alloy with
// shape memory'; Seelecke and Müller 2004, 'Shape memory alloy actuators in smart structures'):
// wells of the free energy, Arrhenius' law, a distribution of interaction stresses. The R-phase as
// a third well and the numbers are ours. It shares neither curves nor memory with the three-phase
// model and the sublayers, and is a plant to judge observers by, never to choose anything.
//
// Two wells of equal stiffness E, which lie a strain ε_t apart, have a barrier that falls with the
// square of the distance to the stress σ_c at which it is gone (Seelecke and Müller, eq. 3.2):
//
//   ΔG = (σ_c - σ)² / 2E      rate  p = 1/τ exp(-ΔG V / kT)
//
// V: volume that jumps together; τ: time between two attempts. The Clausius-Clapeyron slope
// converts a distance in stress to one in temperature, and sqrt(kTE/V) to a width w in kelvin:
//
//   p(T) = 1/τ exp(-z²/2)     z = max(0, distance of T to where the barrier is gone) / w
//
// The parameters give the temperature at which half of a part jumps within 0.1 s. A part consists
// of martensite m, R-phase r and austenite a = 1 - m - r:
//
//   a <-> r                   at a2r_K, r2a_K
//   a, r -> m -> a            at a2m_K, m2a_K, both warmer by J (<m> - 1/2): neighbours that are
//                             martensite already make the next part's change easier

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "model/kinetics.hpp"
#include "model/plants/threshold_spread.hpp"

namespace smaservo {

/// A few numbers that describe the parts of a wire.
struct FreeEnergySpread {
  ThresholdSpread m2a, a2m, r2a, a2r;
  /// Correlation of a part's interaction stress in A2R and R2A with that in A2M and M2A, -1..1.
  double r_correlation;
  double width_K;     ///< w, > 0
  double attempt_s;   ///< τ, 1e-6 to 1e-2
  double coupling_K;  ///< J, >= 0
};

template <class S, std::size_t parts = 16>
struct FreeEnergy {
  using Scalar = S;
  using PerPart = std::array<S, parts>;
  static_assert(parts % 7 != 0);

  struct Barrier {
    PerPart gone_K;  ///< temperature at which a part's barrier is gone, without stress
    S per_Pa, per_Pa2;
  };

  struct Params {
    Barrier m2a, a2m, r2a, a2r;
    S per_width_1_K;  ///< 1/w
    S tries_1_s;      ///< 1/τ
    S coupling_K;
  };

  struct State {
    PerPart martensite, r_phase;
    Drive<S> drive;
    Phases<S> phases;  ///< means of all parts
    S dt_s;            ///< duration of the last step, for rates()
  };

  /// advance() without a time jumps to the drive and rests there for this time.
  static constexpr S rest_s = S(1);

  static Params params(const FreeEnergySpread& spread) {
    Params p;
    const double beyond_K = spread.width_K * std::sqrt(2 * std::log(half_s / spread.attempt_s));
    const double across = std::sqrt(1 - spread.r_correlation * spread.r_correlation);
    for (std::size_t i = 0; i < parts; ++i) {
      const double m = normal_quantile(i);
      // Any order will do that differs from the martensite's; 7 has no common factor with the
      // number of parts.
      const double r = spread.r_correlation * m + across * normal_quantile(7 * i % parts);
      p.m2a.gone_K[i] = S(at_K(spread.m2a, m) + beyond_K);
      p.r2a.gone_K[i] = S(at_K(spread.r2a, r) + beyond_K);
      p.a2m.gone_K[i] = S(at_K(spread.a2m, m) - beyond_K);
      p.a2r.gone_K[i] = S(at_K(spread.a2r, r) - beyond_K);
    }
    const auto shift = [](const ThresholdSpread& from, Barrier& to) {
      to.per_Pa = S(from.per_Pa);
      to.per_Pa2 = S(from.per_Pa2);
    };
    shift(spread.m2a, p.m2a);
    shift(spread.a2m, p.a2m);
    shift(spread.r2a, p.r2a);
    shift(spread.a2r, p.a2r);
    p.per_width_1_K = S(1 / spread.width_K);
    p.tries_1_s = S(1 / spread.attempt_s);
    p.coupling_K = S(spread.coupling_K);
    return p;
  }

  /// Cooled from far above at 20 K/s, which is about the rate of a thin wire in air.
  static State rest(const Params& p, const Drive<S>& u) {
    State s{};
    const S hot_K = u.temperature_K < S(500) ? S(500) : u.temperature_K;
    for (S T = hot_K; u.temperature_K < T; T -= S(1)) {
      advance(p, s, {T, u.stress_Pa}, S(0.05));
    }
    advance(p, s, u, S(0.05));
    return s;
  }

  static void advance(const Params& p, State& s, const Drive<S>& u) {
    for (int i = 0; i < 8; ++i) {
      advance(p, s, u, S(0.125) * rest_s);
    }
  }

  /// Exact for two wells at a constant drive. Cost: 4 exp() for each part that is transforming,
  /// otherwise a few comparisons.
  static void advance(const Params& p, State& s, const Drive<S>& u, const S& dt_s) {
    const Felt T = felt(p, s, u);
    S m_sum = S(0);
    S r_sum = S(0);
    for (std::size_t i = 0; i < parts; ++i) {
      S& m = s.martensite[i];
      S& r = s.r_phase[i];
      exchange(rate(p, T.a2r_K - p.a2r.gone_K[i]), rate(p, p.r2a.gone_K[i] - T.r2a_K), S(1) - m, r,
               dt_s);
      const S cooling_1_s = rate(p, T.a2m_K - p.a2m.gone_K[i]);
      const S before = m;
      exchange(cooling_1_s, rate(p, p.m2a.gone_K[i] - T.m2a_K), S(1), m, dt_s);
      // Martensite grows from R-phase and austenite in proportion; martensite that transforms back
      // becomes austenite.
      if (before < m) {
        r *= (S(1) - m) / (S(1) - before);
      }
      m_sum += m;
      r_sum += r;
    }
    s.drive = u;
    s.phases = {m_sum / S(parts), r_sum / S(parts)};
    s.dt_s = dt_s;
  }

  static Drive<S> drive(const State& s) { return s.drive; }
  static Phases<S> phases(const State& s) { return s.phases; }

  /// How the result of a next step of the same duration would change with the temperature at its
  /// end.
  static PhaseRates<S> rates(const Params& p, const State& s, Heading /*heading*/) {
    const Felt T = felt(p, s, s.drive);
    S martensite = S(0);
    S r_phase = S(0);
    for (std::size_t i = 0; i < parts; ++i) {
      const S m = s.martensite[i];
      const S r = s.r_phase[i];
      const S by_m = slope(p, T.a2m_K - p.a2m.gone_K[i]) * (S(1) - m) +
                     slope(p, p.m2a.gone_K[i] - T.m2a_K) * m;
      martensite -= by_m;
      r_phase -= slope(p, T.a2r_K - p.a2r.gone_K[i]) * (S(1) - m - r) +
                 slope(p, p.r2a.gone_K[i] - T.r2a_K) * r;
    }
    const S scale = s.dt_s / S(parts);
    return {scale * martensite, scale * r_phase};
  }

 private:
  static constexpr double half_s = 0.1;
  /// A barrier that is farther away than this, in widths, is not crossed: the rate is below
  /// exp(-50).
  static constexpr S far = S(10);

  /// The temperature less the shifts by stress and neighbours, for each process.
  struct Felt {
    S m2a_K, a2m_K, r2a_K, a2r_K;
  };
  static Felt felt(const Params& p, const State& s, const Drive<S>& u) {
    const auto shifted = [&](const Barrier& b) {
      return u.temperature_K - u.stress_Pa * (b.per_Pa + u.stress_Pa * b.per_Pa2);
    };
    const S easier_K = p.coupling_K * (s.phases.martensite - S(0.5));
    return {shifted(p.m2a) - easier_K, shifted(p.a2m) - easier_K, shifted(p.r2a), shifted(p.a2r)};
  }

  /// The rate p(T) at this distance from the temperature at which the barrier is gone.
  static S rate(const Params& p, const S& distance_K) {
    const S z = distance_K * p.per_width_1_K;
    if (far < z) {
      return S(0);
    }
    return S(0) < z ? p.tries_1_s * std::exp(S(-0.5) * z * z) : p.tries_1_s;
  }
  /// -dp/d(distance)
  static S slope(const Params& p, const S& distance_K) {
    const S z = distance_K * p.per_width_1_K;
    return S(0) < z && z < far ? rate(p, distance_K) * z * p.per_width_1_K : S(0);
  }

  /// The share x of the sum `both` of two phases after dt_s, with these rates into x and out of x.
  static void exchange(const S& in_1_s, const S& out_1_s, const S& both, S& x, const S& dt_s) {
    const S sum_1_s = in_1_s + out_1_s;
    if (!(S(0) < sum_1_s)) {
      return;
    }
    const S end = both * in_1_s / sum_1_s;
    const S next = end + (x - end) * std::exp(-sum_1_s * dt_s);
    x = next < S(0) ? S(0) : both < next ? both : next;
  }

  static double at_K(const ThresholdSpread& spread, double score) {
    return spread.median_K + (score < 0 ? spread.below_K : spread.above_K) * score;
  }
  /// The quantile at the middle of the i-th of equal parts, in logistic scales: of a normal
  /// distribution with the logistic distribution's standard deviation, π/√3. Found by bisection of
  /// erfc().
  static double normal_quantile(std::size_t i) {
    const double share = (static_cast<double>(i) + 0.5) / parts;
    double low = -8;
    double high = 8;
    for (int step = 0; step < 60; ++step) {
      const double x = 0.5 * (low + high);
      (0.5 * std::erfc(-x / std::numbers::sqrt2) < share ? low : high) = x;
    }
    return 1.8138 * low;
  }
};

}  // namespace smaservo
