#pragma once
// The classical two-phase model: martensite and austenite, cosine curves over temperature.
// Source: Liang and Rogers (1990), 'One-dimensional thermomechanical constitutive relations for
// shape memory materials'; paper 002 section 6, eq. 31 to 34. The three-phase model with its ihyp
// curves is compared with this one in accuracy and in speed.

#include "model/papers/cosine_process.hpp"

namespace smaservo::papers {

/// The model: one of Kinetics.
template <class S>
struct Cosine {
  using Scalar = S;

  /// The two processes.
  struct Params {
    CosineProcess<S> m2a;  ///< A_s, A_f, C_A
    CosineProcess<S> a2m;  ///< M_s, M_f, C_M
  };

  /// Fraction and history; trivially copyable.
  struct State {
    Drive<S> drive;
    S martensite;
    CosineBranch<S> branch;  ///< `martensite` is the fraction at its farthest progress
    Heading heading;
  };

  /// A wire that was cooled to this temperature at this stress from far above.
  static State rest(const Params& p, const Drive<S>& u) {
    const S x = p.a2m.progress(u);
    return {u, S(1) - cosine_left(x), {S(1), x}, Heading::cooling};
  }

  /// Exact for any step size. A process acts while its progress grows beyond the farthest of its
  /// branch; a new branch begins at the drive before the step, scaled to the fraction there. If
  /// stress and temperature rise so that both processes could act, the one that is already acting
  /// does. Cost: one cosine on a branch, two at a reversal, none outside start to finish.
  static void advance(const Params& p, State& s, const Drive<S>& u) {
    const S x = process(p, s.heading).progress(u);
    if (s.branch.progress < x) {
      convert(s, x);
    } else {
      const Heading turned = s.heading == Heading::heating ? Heading::cooling : Heading::heating;
      const S from = process(p, turned).progress(s.drive);
      const S to = process(p, turned).progress(u);
      if (from < to) {
        s.heading = turned;
        s.branch = CosineBranch<S>::at(pool(s, turned), from);
        convert(s, to);
      }
    }
    s.drive = u;
  }

  /// Where the last step went.
  static Drive<S> drive(const State& s) { return s.drive; }
  /// The fractions after it.
  static Phases<S> phases(const State& s) { return {s.martensite, S(0)}; }

  /// Slopes for a small step in this heading at constant stress.
  static PhaseRates<S> rates(const Params& p, const State& s, Heading heading) {
    const CosineProcess<S>& acting = process(p, heading);
    const S x = acting.progress(s.drive);
    if (heading == s.heading && x < s.branch.progress) {
      return {S(0), S(0)};
    }
    const CosineBranch<S> branch =
        heading == s.heading ? s.branch : CosineBranch<S>::at(pool(s, heading), x);
    const S pool_1_K = branch.pool_1_K(acting, x);
    return {heading == Heading::heating ? pool_1_K : -pool_1_K, S(0)};
  }

 private:
  static const CosineProcess<S>& process(const Params& p, Heading heading) {
    return heading == Heading::heating ? p.m2a : p.a2m;
  }

  /// The phase that a process consumes: martensite when heating, austenite when cooling.
  static S pool(const State& s, Heading heading) {
    return heading == Heading::heating ? s.martensite : S(1) - s.martensite;
  }

  static void convert(State& s, const S& x) {
    const S after = s.branch.convert(pool(s, s.heading), x);
    s.martensite = s.heading == Heading::heating ? after : S(1) - after;
  }
};

}  // namespace smaservo::papers
