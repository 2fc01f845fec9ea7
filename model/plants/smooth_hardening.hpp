#pragma once
// A wire whose transformations harden smoothly: each has a first and a last temperature,
// and exponents that say how gently it begins and ends.
// Source: Lagoudas, Hartl, Chemisky, Machado and Popov 2012, 'Constitutive model for the numerical
// analysis of phase transformation in polycrystalline shape memory alloys': the hardening function
// and its exponents, the transformation surfaces evaluated at the present fraction, the
// transformation strain that saturates with stress. The R-phase and the numbers are ours. It shares
// neither curves nor memory with the three-phase model, the sublayers and the free energy, and is a
// plant to judge observers by, never to choose anything.
//
// The driving force of a transformation is linear in temperature, and has to overcome the hardening
// h of what has been converted, x. So at constant stress
//
//   T(x) = T_from + (T_to - T_from) h(x)        h(x) = 1/2 (1 + x^n - (1 - x)^m)
//
// With n and m below 1 the slope dx/dT is 0 at both ends; n = m = 1 is a straight line. Stress does
// work on the transformation strain, H(σ) = H_sat (1 - d exp(-σ/σ_H)), and on the difference of the
// compliances, and shifts a transformation by that work (Clausius and Clapeyron):
//
//   shift = a (σ - d σ_H (1 - exp(-σ/σ_H))) + b σ²        for the R-phase d = 0
//
// Two transformations are independent of each other: martensite m grows from its parent phase and
// becomes it again; in the parent the R-phase has the share q. So R-phase is r = (1 - m) q.
//
//   m: at a2m on cooling, at m2a on heating
//   q: at a2r on cooling, at r2a on heating
//
// Between its two temperatures T(x) a fraction rests: a play, as each sublayer is, but a single one
// that is as wide as the whole hysteresis. What has transformed last goes back first; an
// interrupted transformation goes on where it was left.

#include <cmath>
#include <limits>

#include "model/kinetics.hpp"

namespace smaservo {

/// One transformation: where it begins and ends without stress, and its hardening.
template <class S>
struct SmoothTransformation {
  S from_K, to_K;     ///< T_from, T_to; to_K is the higher one on heating
  S first, last;      ///< n and m of h(x), both in 0.05..1
  S per_Pa, per_Pa2;  ///< a and b of the shift by stress

  /// h(x), and its derivative.
  struct Hardening {
    S value, slope;
  };
  /// Cost: two powers. x within 0..1; where the slope is infinite, at both ends, it is great.
  constexpr Hardening hardening(const S& x) const {
    const S begun = x < least ? S(least) : x;
    const S left = S(1) - x < least ? S(least) : S(1) - x;
    const S a = std::pow(begun, first);
    const S b = std::pow(left, last);
    return {S(0.5) * (S(1) + (S(0) < x ? a : S(0)) - (x < S(1) ? b : S(0))),
            S(0.5) * (first * a / begun + last * b / left)};
  }
  /// T(x) without stress.
  constexpr S at_K(const S& x) const { return from_K + (to_K - from_K) * hardening(x).value; }
  /// dx/dT at x.
  constexpr S slope_1_K(const S& x) const { return S(1) / ((to_K - from_K) * hardening(x).slope); }

  /// The x with T(x) = T, where T has gone beyond the temperature at which `before` was reached.
  /// Newton's method within the bracket before..1: a small step needs one or two turns, a great one
  /// about ten.
  constexpr S converted(const S& T, const S& before) const {
    const S goal = (T - from_K) / (to_K - from_K);
    if (!(goal < S(1))) {
      return S(1);
    }
    if (!(S(0) < goal)) {
      return before;
    }
    S low = before;
    S high = S(1);
    S x = before;
    if (x < least) {
      // h(x) >= x^n/2
      const S most = S(2) * goal < S(1) ? std::pow(S(2) * goal, S(1) / first) : S(1);
      x = most < S(0.5) ? most : S(0.5);
    }
    for (int turn = 0; turn < 100; ++turn) {
      const Hardening h = hardening(x);
      (h.value < goal ? low : high) = x;
      S next = x - (h.value - goal) / h.slope;
      if (!(low < next && next < high)) {
        next = S(0.5) * (low + high);
      }
      const S change = next < x ? x - next : next - x;
      x = next;
      if (!(S(4) * std::numeric_limits<S>::epsilon() < change)) {
        break;
      }
    }
    return x;
  }

  static constexpr S least = S(1e-30);
};

/// A wire's transformations without stress. At every fraction and stress m2a lies above a2m and r2a
/// above a2r.
struct SmoothHardeningNumbers {
  SmoothTransformation<double> m2a, a2m, r2a, a2r;
  double
      strain_deficit;    ///< d: share of martensite's strain that is missing without stress, 0..0.9
  double saturation_Pa;  ///< σ_H, > 0
};

template <class S>
struct SmoothHardening {
  using Scalar = S;

  struct Params {
    SmoothTransformation<S> m2a, a2m, r2a, a2r;
    S strain_deficit, saturation_Pa;
  };

  /// A fraction, and the temperatures without stress at which it begins to move.
  struct Fraction {
    S share;          ///< 0..1
    S hot_K, cold_K;  ///< it falls above the one and grows below the other
  };

  struct State {
    Fraction martensite;  ///< m
    Fraction r_share;     ///< q
    Drive<S> drive;
    S strained_Pa;  ///< the integral of H(σ)/H_sat over the stress
  };

  static Params params(const SmoothHardeningNumbers& numbers) {
    const auto of = [](const SmoothTransformation<double>& t) {
      return SmoothTransformation<S>{S(t.from_K), S(t.to_K),   S(t.first),
                                     S(t.last),   S(t.per_Pa), S(t.per_Pa2)};
    };
    return {of(numbers.m2a), of(numbers.a2m),           of(numbers.r2a),
            of(numbers.a2r), S(numbers.strain_deficit), S(numbers.saturation_Pa)};
  }

  static State rest(const Params& p, const Drive<S>& u) {
    State s{{S(0), p.m2a.to_K, p.a2m.from_K},
            {S(0), p.r2a.to_K, p.a2r.from_K},
            {S(1e4), u.stress_Pa},
            strained_Pa(p, u.stress_Pa)};
    advance(p, s, u);
    return s;
  }

  /// Exact for any step on which temperature and stress push in the same direction. Cost: two
  /// comparisons for a fraction that rests, four to eight powers for one that moves; an exponential
  /// where the stress has changed.
  static void advance(const Params& p, State& s, const Drive<S>& u) {
    if (u.stress_Pa < s.drive.stress_Pa || s.drive.stress_Pa < u.stress_Pa) {
      s.strained_Pa = strained_Pa(p, u.stress_Pa);
    }
    s.drive = u;
    move(p.m2a, p.a2m, u, s.strained_Pa, s.martensite);
    move(p.r2a, p.a2r, u, u.stress_Pa, s.r_share);
  }

  static Drive<S> drive(const State& s) { return s.drive; }
  static Phases<S> phases(const State& s) {
    return {s.martensite.share, (S(1) - s.martensite.share) * s.r_share.share};
  }

  static PhaseRates<S> rates(const Params& p, const State& s, Heading heading) {
    const S m_1_K = rate(p.m2a, p.a2m, s.drive, s.strained_Pa, s.martensite, heading);
    const S q_1_K = rate(p.r2a, p.a2r, s.drive, s.drive.stress_Pa, s.r_share, heading);
    return {m_1_K, (S(1) - s.martensite.share) * q_1_K - s.r_share.share * m_1_K};
  }

 private:
  /// σ - d σ_H (1 - exp(-σ/σ_H))
  static S strained_Pa(const Params& p, const S& stress_Pa) {
    return stress_Pa -
           p.strain_deficit * p.saturation_Pa * (S(1) - std::exp(-stress_Pa / p.saturation_Pa));
  }
  /// The temperature less the shift by the stress.
  static S felt_K(const SmoothTransformation<S>& t, const Drive<S>& u, const S& strained_Pa) {
    return u.temperature_K - t.per_Pa * strained_Pa - t.per_Pa2 * u.stress_Pa * u.stress_Pa;
  }

  static void move(const SmoothTransformation<S>& heating, const SmoothTransformation<S>& cooling,
                   const Drive<S>& u, const S& strained_Pa, Fraction& x) {
    const S cold_K = felt_K(cooling, u, strained_Pa);
    if (cold_K < x.cold_K) {
      if (x.share < S(1)) {
        x.share = cooling.converted(cold_K, x.share);
        x.cold_K = cold_K;
        x.hot_K = heating.at_K(S(1) - x.share);
      }
      return;
    }
    const S hot_K = felt_K(heating, u, strained_Pa);
    if (x.hot_K < hot_K && S(0) < x.share) {
      x.share = S(1) - heating.converted(hot_K, S(1) - x.share);
      x.hot_K = hot_K;
      x.cold_K = cooling.at_K(x.share);
    }
  }

  /// The slope of a fraction over the temperature, if it is moving.
  static S rate(const SmoothTransformation<S>& hotter, const SmoothTransformation<S>& colder,
                const Drive<S>& u, const S& strained_Pa, const Fraction& x, Heading heading) {
    if (heading == Heading::heating) {
      const bool rests = felt_K(hotter, u, strained_Pa) < x.hot_K || !(S(0) < x.share);
      return rests ? S(0) : -hotter.slope_1_K(S(1) - x.share);
    }
    const bool rests = x.cold_K < felt_K(colder, u, strained_Pa) || !(x.share < S(1));
    return rests ? S(0) : colder.slope_1_K(x.share);
  }
};

}  // namespace smaservo
