#pragma once
// A differential hysteresis model of two phases: martensite over temperature. The slopes of its
// major loop are Gaussian; those of minor loops are scaled by the position within the major loop.
// Source: paper 001 section III, eq. 4 to 12; the minor loops are Likhachev's. The paper has no
// stress: here it shifts the centres.

#include <cmath>
#include <numbers>

#include "model/kinetics.hpp"

namespace smaservo::papers {

/// The model: one of Kinetics.
template <class S>
struct Duhem {
  using Scalar = S;

  /// One direction of the major loop: the share of a Gaussian that lies below the temperature.
  struct Process {
    S centre_K;     ///< μ, at zero stress
    S deviation_K;  ///< σ of the paper, > 0
    S stress_K_Pa;  ///< shift of μ per stress, the inverse Clausius-Clapeyron slope; 0 in 001

    /// How far the drive is above the centre, in deviations.
    constexpr S deviations(const Drive<S>& u) const {
      return (u.temperature_K - centre_K - stress_K_Pa * u.stress_Pa) / deviation_K;
    }
  };

  /// There is a loop only where μ_+ is above μ_-: at drives where the heating curve does not lie
  /// below the cooling curve, the cooling curve serves for both directions. With unequal deviations
  /// the curves always cross somewhere, at (μ_+ - μ_-)/(σ_+ - σ_-) deviations from both centres:
  /// 8.3 in 001, where less than 1e-16 is left to transform.
  struct Params {
    Process m2a;  ///< μ_+, σ_+
    Process a2m;  ///< μ_-, σ_-
  };

  /// The last drive and the fraction there; trivially copyable.
  struct State {
    Drive<S> drive;
    S martensite;
  };

  /// Whether there is a loop at this drive.
  static bool ordered(const Params& p, const Drive<S>& u) { return has_loop(heating_place(p, u)); }

  /// A wire that was cooled to this temperature at this stress from far above.
  static State rest(const Params& p, const Drive<S>& u) { return {u, right(p.a2m.deviations(u))}; }

  /// The path to the drive is straight in temperature and stress. A process acts on it while its
  /// own curve advances, so stress transforms, too. One step equals many to 1e-10 of a fraction
  /// while the curves are a deviation or more apart; where a stress pushes both processes at once,
  /// M2A goes first, an error of first order. As in the paper there is no memory: every rise and
  /// fall of a ripple converts a little, so minor loops do not close and the fraction drifts to
  /// where both directions balance. Cost: 2 complementary error functions for each process that
  /// acts, plus 8 of them and 4 exponentials for each half deviation of the path.
  static void advance(const Params& p, State& s, const Drive<S>& u) {
    const Place from = heating_place(p, s.drive);
    const Place to = heating_place(p, u);
    s.drive = u;
    if (!has_loop(to)) {
      s.martensite = right(to.other);
      return;
    }
    if (from.own < to.own) {
      s.martensite = converted(s.martensite, from, to);
    }
    if (to.other < from.other) {
      s.martensite = S(1) - converted(S(1) - s.martensite, mirrored(from), mirrored(to));
    }
  }

  /// Where the last step went.
  static Drive<S> drive(const State& s) { return s.drive; }
  /// The fractions after it.
  static Phases<S> phases(const State& s) { return {s.martensite, S(0)}; }

  /// Slopes for a small step in this heading at constant stress (001 eq. 12).
  static PhaseRates<S> rates(const Params& p, const State& s, Heading heading) {
    const Place place = heating_place(p, s.drive);
    if (!has_loop(place)) {
      return {-density(place.other) / p.a2m.deviation_K, S(0)};
    }
    return heading == Heading::heating
               ? PhaseRates<S>{slope(s.martensite, place) / p.m2a.deviation_K, S(0)}
               : PhaseRates<S>{slope(S(1) - s.martensite, mirrored(place)) / p.a2m.deviation_K,
                               S(0)};
  }

 private:
  /// The positions of the acting process and of the other one, in deviations from their centres,
  /// counted so that the acting one rises. Cooling is the mirror image of heating, with austenite
  /// in place of martensite, so the formulas are written once. `pool` is the phase that the acting
  /// process consumes.
  struct Place {
    S own, other;
  };

  static Place heating_place(const Params& p, const Drive<S>& u) {
    return {p.m2a.deviations(u), p.a2m.deviations(u)};
  }
  static Place mirrored(const Place& place) { return {-place.other, -place.own}; }
  static bool has_loop(const Place& place) { return place.own < place.other; }

  /// The share of a Gaussian that lies above z: 1 - h of 001 eq. 6.
  static S right(const S& z) {
    using std::erfc;
    return S(0.5) * erfc(S(1 / std::numbers::sqrt2) * z);
  }
  // 001 eq. 5, for a deviation of 1
  static S density(const S& z) {
    using std::exp;
    return S(0.5 * std::numbers::sqrt2 * std::numbers::inv_sqrtpi) * exp(S(-0.5) * z * z);
  }

  /// The major loop at a place: the shares of the pool that both curves have left, and their
  /// distance.
  struct Band {
    S own, other, width;
  };
  static Band band(const Place& place) {
    if (place.other < S(0)) {
      // Both shares are near 1: the difference is taken from the small complements.
      const S own = right(-place.own);
      const S other = right(-place.other);
      return {S(1) - own, S(1) - other, other - own};
    }
    const S own = right(place.own);
    const S other = right(place.other);
    return {own, other, own - other};
  }

  /// Change of the pool per deviation of the acting process.
  static S slope(const S& pool, const Place& place) {
    const Band major = band(place);
    const S above = pool - major.other;
    // 001 eq. 9, in 0..1; anything outside is rounding
    const S n = !(S(0) < above) ? S(0) : above < major.width ? above / major.width : S(1);
    return -n * density(place.own);
  }

  /// The pool that is left after a straight path. With a and b the places of both processes, p the
  /// pool and Q = right, 001 eq. 11 reads dp/da = -φ(a) (p - Q(b))/(Q(a) - Q(b)). The distance from
  /// the acting curve, Q(a) - p, obeys an equation without p, and its solution is
  ///     p_1 = Q(a_1)/Q(a_0) [p_0 + (Q(a_0) - p_0) (1 - e^-c)].
  /// The fraction Q(a_1)/Q(a_0) alone is the closed form where the two curves do not overlap; c is
  /// the effect of the overlap.
  static S converted(const S& pool, const Place& from, const Place& to) {
    using std::expm1;
    const S begun = right(from.own);
    const S ended = right(to.own);
    const S max = pool < begun ? pool : begun;
    if (!(S(0) < begun)) {
      return S(0);
    }
    S left = max;
    if (max < begun) {
      left -= (begun - max) * expm1(-overlap(from, to));
    }
    left *= ended / begun;
    const S min = right(to.other);
    return left < min ? min : left;
  }

  /// c = ∫ φ(a)/Q(a) q/(1 - q) da with q = Q(b)/Q(a), by four-point Gauss-Legendre quadrature in
  /// each half deviation. The part more than 8.5 deviations from the centre is below rounding.
  static S overlap(const Place& from, const Place& to) {
    const S own = to.own - from.own;
    const S other = to.other - from.other;
    S begin = (S(-8.5) - from.own) / own;
    S end = (S(8.5) - from.own) / own;
    begin = begin < S(0) ? S(0) : begin;
    end = S(1) < end ? S(1) : end;
    if (S(0) < other && (S(8.5) - from.other) / other < end) {
      end = (S(8.5) - from.other) / other;
    }
    if (!(begin < end)) {
      return S(0);
    }
    const S span = (end - begin) * (own < other ? other : own);
    int parts = 1;
    while (parts < 64 && S(0.5) * S(parts) < span) {
      parts *= 2;
    }
    const S half = (end - begin) / S(2 * parts);
    S sum = S(0);
    for (int part = 0; part < parts; ++part) {
      const S middle = begin + half * S(2 * part + 1);
      const auto pair = [&](double place) {
        const S reach = S(place) * half;
        return overlap_slope(at(from, own, other, middle - reach)) +
               overlap_slope(at(from, own, other, middle + reach));
      };
      sum += S(0.6521451548625461) * pair(0.3399810435848563) +
             S(0.3478548451374538) * pair(0.8611363115940526);
    }
    return sum * half * own;
  }

  static Place at(const Place& from, const S& own, const S& other, const S& way) {
    return {from.own + way * own, from.other + way * other};
  }

  static S overlap_slope(const Place& place) {
    const Band major = band(place);
    if (!(S(0) < major.width)) {
      return S(1e6);  // no width left: the pool falls onto the acting curve at once
    }
    return density(place.own) * major.other / (major.own * major.width);
  }
};

}  // namespace smaservo::papers
