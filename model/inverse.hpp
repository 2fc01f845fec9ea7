#pragma once
// The three-phase model the other way round: the temperature at which a wire, from where it is now,
// would have a given strain. Explicit, as the ihyp curve is in this direction (000, 'Inverse'):
// along the branch and its turning points, no iteration.

#include <cstddef>

#include "model/plant.hpp"

namespace smaservo {

/// A place on the branch ahead of a wire.
template <class S>
struct BranchPoint {
  S temperature_K;
  Phases<S> phases;  ///< of the wire's middle
};

template <class S, std::size_t depth = 8>
struct Inverse {
  using K = ThreePhase<S, depth>;
  using Model = Plant<K>;

  /// Where heating brings the wire to `goal`, a strain not above its present one. Below what heat
  /// can do: the end of the transformation, 98 % of it. Exact for a wire whose R2A shares M2A's
  /// surface.
  static BranchPoint<S> heating(const typename Model::Params& p, const typename K::State& s,
                                const S& stress_Pa, const S& goal);

  /// Where cooling does, with `goal` not below the present strain. The R-phase on the way is taken
  /// to come and go in step with martensite: up to 5 % of the stroke off where there is much of it
  /// (below 100 MPa), exact at the goal's turning points.
  static BranchPoint<S> cooling(const typename Model::Params& p, const typename K::State& s,
                                const S& stress_Pa, const S& goal);

 private:
  /// Strain by the phases of the middle.
  struct Slopes {
    S none, martensite, r_phase;
    S strain(const S& m, const S& r) const { return none + m * martensite + r * r_phase; }
  };
  static Slopes slopes(const typename Model::Params& p, const S& stress_Pa) {
    const StrainSlopes<S> by = strain_slopes(p.material, stress_Pa);
    const S middle = S(1) - p.ends.share;
    const Phases<S> cold = p.ends.phases;
    return {
        by.austenite + p.ends.share * (cold.martensite * by.martensite + cold.r_phase * by.r_phase),
        middle * by.martensite, middle * by.r_phase};
  }

  /// How far from here to there, at most `most`.
  static S share(const S& from, const S& to, const S& goal, const S& most) {
    const S way = to - from;
    const S tiny = S(1e-7);
    if (way < tiny && S(0) - tiny < way) {
      return most;
    }
    const S part = (goal - from) / way;
    return part < S(0) ? S(0) : most < part ? most : part;
  }
  static S temperature_K(const Isobar<S>& at, const S& left) {
    const S least = S(1e-3);
    const S bounded = left < least ? least : S(1) - least < left ? S(1) - least : left;
    return at.start_K + ihyp_temperature(at.shape, {S(1) - bounded, bounded}) / at.per_K;
  }
  static constexpr S furthest = S(0.98);
};

template <class S, std::size_t depth>
BranchPoint<S> Inverse<S, depth>::heating(const typename Model::Params& p,
                                          const typename K::State& s, const S& stress_Pa,
                                          const S& goal) {
  const Slopes by = slopes(p, stress_Pa);
  const Isobar<S> at = isobar(p.kinetics.m2a, stress_Pa);
  Phases<S> from = K::phases(s);
  S left = s.heading == Heading::heating ? s.reverse.m2a : at.remaining(s.reached.temperature_K);
  const auto& turns = s.hot;
  // From the newest turning point outwards; the last one is the end at infinity.
  for (std::size_t i = turns.size();; --i) {
    const typename K::HotTurn& turn = turns.at(i);
    const S there = by.strain(turn.martensite, turn.r_phase);
    const S here = by.strain(from.martensite, from.r_phase);
    if (i == 0 || there < goal) {
      const S part = share(here, there, goal, i == 0 ? furthest : S(1));
      return {temperature_K(at, left + part * (turn.left.m2a - left)),
              {from.martensite + part * (turn.martensite - from.martensite),
               from.r_phase + part * (turn.r_phase - from.r_phase)}};
    }
    from = {turn.martensite, turn.r_phase};
    left = turn.left.m2a;
  }
}

template <class S, std::size_t depth>
BranchPoint<S> Inverse<S, depth>::cooling(const typename Model::Params& p,
                                          const typename K::State& s, const S& stress_Pa,
                                          const S& goal) {
  const Slopes by = slopes(p, stress_Pa);
  const Isobar<S> at = first_isobar(isobar(p.kinetics.a2m_a2r, Pair<S>(stress_Pa)));
  Phases<S> from = K::phases(s);
  S left = s.heading == Heading::cooling ? s.forward.a2m_a2r.first()
                                         : at.remaining(s.reached.temperature_K);
  const auto& turns = s.cold;
  for (std::size_t i = turns.size();; --i) {
    const typename K::ColdTurn& turn = turns.at(i);
    const Phases<S> to{S(1) - turn.austenite - turn.r_phase, turn.r_phase};
    const S there = by.strain(to.martensite, to.r_phase);
    const S here = by.strain(from.martensite, from.r_phase);
    if (i == 0 || goal < there) {
      const S part = share(here, there, goal, i == 0 ? furthest : S(1));
      return {temperature_K(at, left + part * (turn.left.a2m_a2r.first() - left)),
              {from.martensite + part * (to.martensite - from.martensite),
               from.r_phase + part * (to.r_phase - from.r_phase)}};
    }
    from = to;
    left = turn.left.a2m_a2r.first();
  }
}

}  // namespace smaservo
