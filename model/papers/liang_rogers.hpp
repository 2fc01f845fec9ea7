#pragma once
// The augmented Liang-Rogers model: martensite, R-phase and austenite by cosines over temperature.
// Source: paper 002 section 6, eq. 29 to 34, 48 and 49, which follow Brammajyosula (2007).
//
//   heating: M2A and R2A along A_s, A_f, C_A       cooling: A2R along R_s, R_f, C_R
//                                                           A2M and R2M along M_s, M_f, C_M
//
// Added here, because 002 has no equations for it: martensite grows at the expense of both other
// phases in proportion, and austenite becomes R-phase at the same time, so eq. 48 gives the share
// of R-phase in the part that is not martensite, at any temperature. On heating the R-phase follows
// eq. 31, too.

#include "model/papers/cosine_process.hpp"
#include "model/wire/material.hpp"

namespace smaservo::papers {

/// The model: one of Kinetics.
template <class S>
struct LiangRogers {
  using Scalar = S;

  /// The three processes.
  struct Params {
    CosineProcess<S> m2a;  ///< A_s, A_f, C_A
    CosineProcess<S> a2m;  ///< M_s, M_f, C_M
    CosineProcess<S> a2r;  ///< R_s, R_f, C_R
  };

  /// The fractions belong to the farthest progress of the branches.
  struct State {
    Drive<S> drive;
    S martensite, r_phase;
    /// The branch of the pool: martensite and R-phase on heating, everything but martensite on
    /// cooling.
    CosineBranch<S> main;
    /// On cooling, the branch of austenite's share in the part that is not martensite.
    CosineBranch<S> share;
    Heading heading;
  };

  /// A wire that was cooled to this temperature at this stress from far above.
  static State rest(const Params& p, const Drive<S>& u) {
    const S x = p.a2m.progress(u);
    const S y = p.a2r.progress(u);
    const S others = cosine_left(x);
    return {u,         S(1) - others, others * (S(1) - cosine_left(y)),
            {S(1), x}, {S(1), y},     Heading::cooling};
  }

  /// Exact for any step size. A direction acts while one of its processes advances beyond the
  /// farthest progress of its branch; a new branch begins at the drive before the step, scaled to
  /// the fractions there, as in eq. 31 and 33. If stress and temperature rise so that both
  /// directions could act, the one that is already acting does. Cost: up to two cosines on a
  /// branch, four at a reversal.
  static void advance(const Params& p, State& s, const Drive<S>& u) {
    if (s.heading == Heading::heating) {
      if (!heat(p, s, u) && cools(p, s.drive, u)) {
        s.heading = Heading::cooling;
        begin_cooling(p, s);
        cool(p, s, u);
      }
    } else if (!cool(p, s, u) && p.m2a.progress(s.drive) < p.m2a.progress(u)) {
      s.heading = Heading::heating;
      s.main = CosineBranch<S>::at(s.martensite + s.r_phase, p.m2a.progress(s.drive));
      heat(p, s, u);
    }
    s.drive = u;
  }

  /// Where the last step went.
  static Drive<S> drive(const State& s) { return s.drive; }
  /// The fractions after it.
  static Phases<S> phases(const State& s) { return {s.martensite, s.r_phase}; }

  /// Slopes for a small step in this heading at constant stress.
  static PhaseRates<S> rates(const Params& p, const State& s, Heading heading) {
    return heading == Heading::heating ? heating_rates(p, s) : cooling_rates(p, s);
  }

 private:
  static S others(const State& s) { return S(1) - s.martensite; }
  static S austenite_share(const State& s) {
    const S pool = others(s);
    return S(0) < pool ? phases(s).austenite() / pool : S(0);
  }

  static bool heat(const Params& p, State& s, const Drive<S>& u) {
    const S x = p.m2a.progress(u);
    const bool acts = s.main.progress < x;
    const S before = s.martensite + s.r_phase;
    if (acts && S(0) < before) {
      const S factor = s.main.convert(before, x) / before;
      s.martensite *= factor;
      s.r_phase *= factor;
    }
    return acts;
  }

  static bool cools(const Params& p, const Drive<S>& from, const Drive<S>& to) {
    return p.a2m.progress(from) < p.a2m.progress(to) || p.a2r.progress(from) < p.a2r.progress(to);
  }

  static void begin_cooling(const Params& p, State& s) {
    s.main = CosineBranch<S>::at(others(s), p.a2m.progress(s.drive));
    s.share = CosineBranch<S>::at(austenite_share(s), p.a2r.progress(s.drive));
  }

  static bool cool(const Params& p, State& s, const Drive<S>& u) {
    const S x = p.a2m.progress(u);
    const S y = p.a2r.progress(u);
    const bool to_martensite = s.main.progress < x;
    const bool to_r_phase = s.share.progress < y;
    if (!to_martensite && !to_r_phase) {
      return false;
    }
    S share = austenite_share(s);
    S pool = others(s);
    if (to_r_phase) {
      share = s.share.convert(share, y);
    }
    if (to_martensite) {
      pool = s.main.convert(pool, x);
    }
    s.martensite = S(1) - pool;
    s.r_phase = pool * (S(1) - share);
    return true;
  }

  static PhaseRates<S> heating_rates(const Params& p, const State& s) {
    const S x = p.m2a.progress(s.drive);
    const S pool = s.martensite + s.r_phase;
    const bool turned = s.heading != Heading::heating;
    if ((!turned && x < s.main.progress) || !(S(0) < pool)) {
      return {S(0), S(0)};
    }
    const CosineBranch<S> branch = turned ? CosineBranch<S>::at(pool, x) : s.main;
    const S relative_1_K = branch.pool_1_K(p.m2a, x) / pool;
    return {s.martensite * relative_1_K, s.r_phase * relative_1_K};
  }

  static PhaseRates<S> cooling_rates(const Params& p, State s) {
    if (s.heading != Heading::cooling) {
      begin_cooling(p, s);
    }
    const S x = p.a2m.progress(s.drive);
    const S y = p.a2r.progress(s.drive);
    const S pool_1_K = x < s.main.progress ? S(0) : s.main.pool_1_K(p.a2m, x);
    const S share_1_K = y < s.share.progress ? S(0) : s.share.pool_1_K(p.a2r, y);
    return {-pool_1_K, pool_1_K * (S(1) - austenite_share(s)) - others(s) * share_1_K};
  }
};

/// Strain with mixed moduli: ε = σ/E + Σ z_i ε_i, E = Σ z_i E_i (002 eq. 29 and 30 with the terms
/// of the R-phase). For a single phase it equals strain(); a mixture is stiffer than there, because
/// here all phases have the same strain and in strain() all bear the same stress. The resistivity
/// is that of Material with Mixture::series (eq. 3), where k = α ρ_0 (eq. 2).
template <class S>
constexpr S mixed_modulus_strain(const Material<S>& m, const Phases<S>& z, const S& stress_Pa) {
  const S a = z.austenite();
  const S E = z.martensite * m.martensite.modulus_Pa + z.r_phase * m.r_phase.modulus_Pa +
              a * m.austenite.modulus_Pa;
  return stress_Pa / E + z.martensite * m.martensite.strain + z.r_phase * m.r_phase.strain +
         a * m.austenite.strain;
}

}  // namespace smaservo::papers
