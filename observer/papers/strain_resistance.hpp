#pragma once
// Strain from resistance and stress by two straight lines, one for heating and one for cooling,
// whose coefficients are polynomials of the stress, and by exponential transitions between them.
// Source: paper 002 section 4, eq. 5 to 28, in its normalised form. No heat, no power.
//
//   strain                          Heating goes down the left line, cooling up the right one.
//   After
//     |              / . /          a reversal at x the slope is a_0 far from the line that is
//     |   heating   / . x           headed for and grows to that line's own:
//     |            / . . /
//     |           / . . / cooling   a = (a_line - a_0) exp(-τ z) + a_0
//     |          /     /
//     +--------------------- λ      with z the distance to the line along λ
//
// Ours: a step is integrated in closed form, so it is exact for any size at one stress, whereas eq.
// 28 uses the slope at its start. Noise must not reverse the heading, or it drives the strain to
// the middle of the loop: the resistance is smoothed, and only a large enough reversal counts. Two
// hypotheses of the strain are carried along from the start, one from each line: while they differ
// the strain is not known.

#include <cmath>
#include <limits>

#include "model/papers/resistance_lines.hpp"
#include "observer/estimate.hpp"

namespace smaservo::papers {

/// Σ β_i (σ/σ_max)^i, i = 0..4 (002 eq. 7 to 10 and 22 to 25, whose exponents i - 1 can only be i).
template <class S>
struct StressPolynomial {
  static constexpr int order = 4;
  S coefficient[order + 1];

  /// Its value at the share σ/σ_max of the greatest stress.
  constexpr S at(const S& share) const {
    S sum = coefficient[order];
    for (int i = order - 1; i >= 0; --i) {
      sum = sum * share + coefficient[i];
    }
    return sum;
  }
};

/// A line ε = a λ + b whose coefficients depend on the stress.
template <class S>
struct StressLine {
  StressPolynomial<S> slope, offset;
};

/// The estimator of 002: one of StrainObserver, without temperature or phases, which are NaN.
template <class S>
struct StrainResistance {
  using Scalar = S;

  /// identify_strain_resistance() makes them from measured runs.
  struct Params {
    S martensite_ohm;  ///< R_0: λ = R/R_0 (002 eq. 17)
    /// Range in which the lines were identified; σ_max is its upper end.
    S min_stress_Pa, max_stress_Pa;
    StressLine<S> heating, cooling;  ///< their slopes exceed initial_slope in that range
    S initial_slope;                 ///< a_0, strain per λ, 0 or more
    S decay;                         ///< τ, per λ, above 0
    S smallest_reversal;             ///< least change of the smoothed λ that counts as a reversal
    S strain_sd;                     ///< rms error in the runs of the identification
  };

  /// What changes; trivially copyable.
  struct State {
    S stress_Pa;
    S smoothed;   ///< λ after the low-pass
    S reached;    ///< λ that the strains belong to: the farthest in this heading
    S low, high;  ///< strains of the two hypotheses
    Heading heading;
  };

  /// Time constant of the low-pass. A wire that contracts in half a second lags by 1 % of its
  /// stroke.
  static constexpr double smoothing_s = 5e-3;

  /// The strains of both lines at the measured resistance, which is λ = 1 where it is not valid.
  static State start(const Params& p, const Measurement<S>& m, const S& /*ambient_K*/) {
    State s{m.stress_Pa, S(1), S(1), S(0), S(0), Heading::cooling};
    if (m.resistance_valid) {
      s.smoothed = s.reached = m.resistance_ohm / p.martensite_ohm;
    }
    const S one = line(p.heating, p, s.stress_Pa).strain(s.reached);
    const S other = line(p.cooling, p, s.stress_Pa).strain(s.reached);
    s.low = one < other ? one : other;
    s.high = one < other ? other : one;
    return s;
  }

  /// Cost: nothing while the resistance stands still, otherwise three exponentials and two
  /// logarithms.
  static void advance(const Params& p, State& s, const Measurement<S>& m, const S& dt_s) {
    if (m.stress_valid) {
      s.stress_Pa = m.stress_Pa;
    }
    if (!m.resistance_valid) {
      return;
    }
    const S weight = dt_s / (dt_s + S(smoothing_s));
    s.smoothed += weight * (m.resistance_ohm / p.martensite_ohm - s.smoothed);
    const S rise = s.smoothed - s.reached;
    // The resistance falls on heating.
    const S ahead = s.heading == Heading::heating ? -rise : rise;
    if (ahead < -p.smallest_reversal) {
      s.heading = s.heading == Heading::heating ? Heading::cooling : Heading::heating;
      move(p, s, -ahead);
    } else if (S(0) < ahead) {
      move(p, s, ahead);
    }
  }

  /// Doubtful if the stress is outside the identified range, whose nearer end is then used;
  /// searching while the two hypotheses differ by more than the standard deviation to either side.
  static Estimate<S> estimate(const Params& p, const State& s) {
    using std::abs;
    using std::sqrt;
    const S nan = std::numeric_limits<S>::quiet_NaN();
    const S apart = S(0.5) * abs(s.high - s.low);
    const bool outside = s.stress_Pa < p.min_stress_Pa || p.max_stress_Pa < s.stress_Pa;
    return {S(0.5) * (s.low + s.high),
            sqrt(p.strain_sd * p.strain_sd + apart * apart),
            nan,
            nan,
            nan,
            nan,
            outside               ? Health::doubtful
            : p.strain_sd < apart ? Health::searching
                                  : Health::good};
  }

  /// The line at a stress, which is clamped to the identified range.
  static ResistanceLine<S> line(const StressLine<S>& lines, const Params& p, const S& stress_Pa) {
    const S clamped = stress_Pa < p.min_stress_Pa   ? p.min_stress_Pa
                      : p.max_stress_Pa < stress_Pa ? p.max_stress_Pa
                                                    : stress_Pa;
    const S share = clamped / p.max_stress_Pa;
    return {lines.slope.at(share), lines.offset.at(share)};
  }

 private:
  /// Moves both strains by `way` in the present heading, from `reached` to `smoothed`.
  static void move(const Params& p, State& s, const S& way) {
    using std::exp;
    const bool heats = s.heading == Heading::heating;
    const ResistanceLine<S> l = line(heats ? p.heating : p.cooling, p, s.stress_Pa);
    const S decayed = exp((p.initial_slope / l.slope - S(1)) * p.decay * way);
    const S sign = heats ? S(1) : S(-1);
    for (S* strain : {&s.low, &s.high}) {
      // 002 eq. 12 and 14
      const S z = sign * (s.reached - (*strain - l.offset) / l.slope);
      *strain = l.slope * (s.smoothed - sign * approached(p, z, decayed)) + l.offset;
    }
    s.reached = s.smoothed;
  }

  /// 002 eq. 11, 13 and 15, integrated: dz/dλ = (1 - a_0/a_line) (1 - exp(-τ z)), hence exp(τ z) -
  /// 1 decays exponentially with λ. A change of the stress may leave a strain beyond the line; z is
  /// then negative and the slope steeper than the line's, so the strain returns to it, too.
  static S approached(const Params& p, const S& z, const S& decayed) {
    using std::exp;
    using std::log;
    // For a greater magnitude exp() would not fit into a float.
    const S farthest = S(-80) / p.decay;
    const S from = z < farthest ? farthest : z;
    const S near = exp(-p.decay * from);
    const S after = from + log(near * (S(1) - decayed) + decayed) / p.decay;
    return S(0) < from && after < S(0) ? S(0) : after;
  }
};

}  // namespace smaservo::papers
