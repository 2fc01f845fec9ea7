#pragma once
// The classical two-phase model: martensite and austenite, cosine curves over temperature.
// Source: Liang and Rogers (1990), 'One-dimensional thermomechanical constitutive relations for
// shape memory materials'; paper 002 section 6, eq. 31 to 34. It is what three phases and ihyp
// curves are compared with, in accuracy and in speed.

#include <cmath>
#include <numbers>

#include "model/kinetics.hpp"

namespace smaservo {

template <class S>
struct Cosine {
  using Scalar = S;

  /// One transformation; start and finish at zero stress, with start_K != finish_K.
  struct Process {
    S start_K;
    S finish_K;
    S stress_Pa_K;  ///< Clausius-Clapeyron slope C, by which stress raises both temperatures

    /// How far the drive is from start to finish, 0..1.
    constexpr S progress(const Drive<S>& u) const {
      const S x = (u.temperature_K - start_K - u.stress_Pa / stress_Pa_K) / (finish_K - start_K);
      return x < S(0) ? S(0) : S(1) < x ? S(1) : x;
    }
  };

  struct Params {
    Process m2a;  ///< A_s, A_f, C_A
    Process a2m;  ///< M_s, M_f, C_M
  };

  struct State {
    Drive<S> drive;
    S martensite;
    S amplitude;  ///< what this branch converts from start to finish; above 1 when it began between
    S progress;   ///< the farthest of this branch; the fraction belongs to it
    Heading heading;
  };

  static State rest(const Params& p, const Drive<S>& u) {
    const S x = p.a2m.progress(u);
    return {u, S(1) - left(x), S(1), x, Heading::cooling};
  }

  /// Exact for any step size. A process acts while its progress grows beyond the branch's
  /// farthest; it begins at the drive before the step, scaled to the fraction there. Where stress
  /// and temperature rise so that both could act, the one that is already acting does.
  /// Cost: one cosine on a branch, two at a reversal, none outside start to finish.
  static void advance(const Params& p, State& s, const Drive<S>& u) {
    const S x = process(p, s.heading).progress(u);
    if (s.progress < x) {
      convert(s, x);
    } else {
      const Heading turned = s.heading == Heading::heating ? Heading::cooling : Heading::heating;
      const S from = process(p, turned).progress(s.drive);
      const S to = process(p, turned).progress(u);
      if (from < to) {
        s.heading = turned;
        s.amplitude = amplitude(s, turned, from);
        convert(s, to);
      }
    }
    s.drive = u;
  }

  static Drive<S> drive(const State& s) { return s.drive; }
  static Phases<S> phases(const State& s) { return {s.martensite, S(0)}; }

  static PhaseRates<S> rates(const Params& p, const State& s, Heading heading) {
    using std::sin;
    const Process& acting = process(p, heading);
    const S x = acting.progress(s.drive);
    if (heading == s.heading && x < s.progress) {
      return {S(0), S(0)};
    }
    const S scale = heading == s.heading ? s.amplitude : amplitude(s, heading, x);
    const S pool_1_K = S(-0.5 * std::numbers::pi) * scale * sin(S(std::numbers::pi) * x) /
                       (acting.finish_K - acting.start_K);
    return {heading == Heading::heating ? pool_1_K : S(0) - pool_1_K, S(0)};
  }

 private:
  static const Process& process(const Params& p, Heading heading) {
    return heading == Heading::heating ? p.m2a : p.a2m;
  }

  /// The phase that a process consumes: martensite when heating, austenite when cooling.
  static S pool(const State& s, Heading heading) {
    return heading == Heading::heating ? s.martensite : S(1) - s.martensite;
  }

  /// What a complete run has left of its pool: (cos(π x) + 1)/2 (002 eq. 31 and 33).
  static S left(const S& x) {
    using std::cos;
    return S(0.5) * cos(S(std::numbers::pi) * x) + S(0.5);
  }

  /// The amplitude of a branch that begins here with the state's fraction.
  static S amplitude(const State& s, Heading heading, const S& x) {
    const S remaining = left(x);
    return S(0) < remaining ? pool(s, heading) / remaining : S(0);
  }

  static void convert(State& s, const S& x) {
    const S before = pool(s, s.heading);
    const S scaled = s.amplitude * left(x);
    const S after = scaled < before ? scaled : before;
    s.martensite = s.heading == Heading::heating ? after : S(1) - after;
    s.progress = x;
  }
};

}  // namespace smaservo
