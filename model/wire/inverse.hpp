#pragma once
// The inverse of the three-phase model: the temperature at which a wire, from its present state,
// would have a given strain. It follows the branch from one turning point to the next. The ihyp
// curve is explicit in this direction (000, 'Inverse'), so nothing iterates to a tolerance.

#include <cstddef>

#include "model/scalar/order.hpp"
#include "model/wire/plant.hpp"

namespace smaservo {

/// A place on the branch ahead of a wire.
template <class S>
struct BranchPoint {
  S temperature_K;
  Phases<S> phases;  ///< fractions in the wire's middle
};

/// The inverse of Plant<ThreePhase<S, depth>>.
template <class S, std::size_t depth = 8>
struct Inverse {
  using K = ThreePhase<S, depth>;
  using Model = Plant<K>;

  /// The point at which heating brings the wire to the strain `goal`, which must not exceed the
  /// present one. If heat cannot reach the goal: the end of the transformation, where 2 % is left.
  /// Exact for a wire whose R2A shares M2A's surface; with a surface of its own the error is up to
  /// 3 % of the stroke below 50 MPa, 1 % from 150 MPa on.
  static BranchPoint<S> heating(const typename Model::Params& p, const typename K::State& s,
                                const S& stress_Pa, const S& goal);

  /// The point at which cooling brings the wire to the strain `goal`, which must not be below the
  /// present one. A2R acts beside A2M there, so this takes two Newton steps from a first guess,
  /// three where the order of the loops matters. Worst error: 4 % of the stroke below 50 MPa, where
  /// there is most R-phase, 1.2 % below 100 MPa, 0.04 % from there on; 0.12 % in 95 of 100 cases.
  /// Where the order matters: 27, 2 and 0.3 %, and 3 % below 50 MPa in 999 of 1000; 0.15 % in 95 of
  /// 100. A greater strain never needs a higher temperature from 50 MPa on, and below that by 0.1 K
  /// at most. An R2M of its own is treated as A2M.
  static BranchPoint<S> cooling(const typename Model::Params& p, const typename K::State& s,
                                const S& stress_Pa, const S& goal);

 private:
  /// The strain of the whole wire as a linear function of the phases of its middle.
  struct Slopes {
    S none, martensite, r_phase;
    S strain(const Phases<S>& z) const {
      return none + z.martensite * martensite + z.r_phase * r_phase;
    }
  };
  static Slopes slopes(const typename Model::Params& p, const S& stress_Pa) {
    const StrainSlopes<S> by = strain_slopes(p.material, stress_Pa);
    const S middle = S(1) - p.ends.share;
    const Phases<S> cold = p.ends.phases;
    return {
        by.austenite + p.ends.share * (cold.martensite * by.martensite + cold.r_phase * by.r_phase),
        middle * by.martensite, middle * by.r_phase};
  }

  /// The share of the way from `from` to `to` that leads to `goal`: 0 to `max`; `max` if the way
  /// has no length.
  static S share(const S& from, const S& to, const S& goal, const S& max) {
    const S way = to - from;
    const S tiny = S(1e-7);
    if (way < tiny && -tiny < way) {
      return max;
    }
    const S part = (goal - from) / way;
    return part < S(0) ? S(0) : max < part ? max : part;
  }
  /// Shares of an outer curve are bounded by this, to either end: beyond, a curve without taper is
  /// hundreds of kelvins long.
  static S least(const Isobar<S>& at) { return S(0) < at.shape.taper ? S(1e-5) : S(1e-3); }
  static S temperature_K(const Isobar<S>& at, const S& left) {
    const S min = least(at);
    const S bounded = left < min ? min : S(1) - min < left ? S(1) - min : left;
    return at.start_K + ihyp_temperature(at.shape, {S(1) - bounded, bounded}) / at.per_K;
  }
  /// The share of the way from here to the end of an outer branch, where 2 % of it are left; where
  /// the order of the loops matters, up to 200 K beyond the start of its curve. No wire is meant to
  /// use the tail beyond.
  static S to_the_end(const LoopOrder<S>& order, const Isobar<S>& at, const S& left) {
    S end = S(0.02);
    if (order.matters()) {
      const S beyond_K = at.per_K < S(0) ? S(-200) : S(200);
      const S farthest = at.remaining(at.start_K + beyond_K);
      end = order.inverse(end * order.q);
      end = end < farthest ? farthest : end;
      end = end < least(at) ? least(at) : end;
    }
    return left < end ? S(0) : S(1) - order(end) / order(left);
  }

  /// The state where a way to a turning point begins.
  struct Start {
    Phases<S> phases;
    Pair<S> left;
    S returning;
    LoopOrder<S> order;
  };
  /// The share of a way that is left, with its slope over temperature.
  struct Line {
    S value, slope_1_K;
  };
  /// The outer curve's share where the part `part` of the way to a turning point is done.
  static S along(const LoopOrder<S>& order, const S& from, const S& to, const S& part) {
    const S begin = order(from);
    return order.inverse(begin + part * (order(to) - begin));
  }
  static Line ratio(const S& left, const S& slope_1_K, const S& way) {
    if (way < S(1e-7) || way < left) {
      return {S(1), S(0)};
    }
    return left < S(0) ? Line{S(0), S(0)} : Line{left / way, slope_1_K / way};
  }

  /// One Newton step on both curves, A2M and A2R, as ThreePhase follows them from the start to the
  /// turning point.
  static void correct(const Slopes& by, const Isobar<Pair<S>>& at, const Start& from,
                      const typename K::ColdTurn& turn, const S& goal, BranchPoint<S>& point);
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
  const auto order = [&](std::size_t i) {
    return K::loop_order(p.kinetics, i < s.cold.size() ? s.cold.at(i + 1).left.a2m_a2r.first()
                                                       : s.forward.a2m_a2r.first());
  };
  // The loop runs from the newest turning point outwards; the last target is the end at infinity.
  for (std::size_t i = turns.size();; --i) {
    const typename K::HotTurn& turn = turns.at(i);
    const S there = by.strain({turn.martensite, turn.r_phase});
    const S here = by.strain(from);
    if (i == 0 || there < goal) {
      const S part = share(here, there, goal, i == 0 ? to_the_end(order(i), at, left) : S(1));
      return {temperature_K(at, along(order(i), left, turn.left.m2a, part)),
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
  const Isobar<Pair<S>> at = isobar(p.kinetics.a2m_a2r, Pair<S>(stress_Pa));
  Start from{K::phases(s), s.forward.a2m_a2r, s.returning, {}};
  if (s.heading == Heading::heating) {
    from.left = at.remaining(Pair<S>(s.reached.temperature_K));
    from.returning = positive(s.cold.newest().r_phase - s.r_phase);
  }
  const auto& turns = s.cold;
  for (std::size_t i = turns.size();; --i) {
    const typename K::ColdTurn& turn = turns.at(i);
    from.order =
        K::loop_order(p.kinetics, i <= s.hot.size() ? s.hot.at(i).left.m2a : s.reverse.m2a);
    const Phases<S> to{S(1) - turn.austenite - turn.r_phase, turn.r_phase};
    const S there = by.strain(to);
    const S here = by.strain(from.phases);
    if (i == 0 || goal < there) {
      // The first guess assumes that R-phase comes and goes in step with martensite.
      const S part =
          share(here, there, goal,
                i == 0 ? to_the_end(from.order, first_isobar(at), from.left.first()) : S(1));
      const S left = along(from.order, from.left.first(), turn.left.a2m_a2r.first(), part);
      BranchPoint<S> point{temperature_K(first_isobar(at), left), {}};
      const int corrections = from.order.matters() ? 3 : 2;
      for (int k = 0; k < corrections; ++k) {
        correct(by, at, from, turn, here + part * (there - here), point);
      }
      return point;
    }
    from = {to, turn.left.a2m_a2r, turn.returning, {}};
  }
}

template <class S, std::size_t depth>
void Inverse<S, depth>::correct(const Slopes& by, const Isobar<Pair<S>>& at, const Start& from,
                                const typename K::ColdTurn& turn, const S& goal,
                                BranchPoint<S>& point) {
  const Pair<S> way = from.left - turn.left.a2m_a2r;
  const Pair<S> left = at.remaining(Pair<S>(point.temperature_K));
  const Pair<S> slope_1_K = at.remaining_1_K(left);
  // Shares that are left of each process' way: of A2M's to the turning point, of A2R's to its end,
  // and of A2R's way back to the turning point, which is 1 before its start.
  const S target = from.order(turn.left.a2m_a2r.first());
  const Line a2m =
      ratio(from.order(left.first()) - target, from.order.slope(left.first()) * slope_1_K.first(),
            from.order(from.left.first()) - target);
  const Line a2r = ratio(left.second(), slope_1_K.second(), from.left.second());
  const Line back =
      ratio(left.second() - turn.left.a2m_a2r.second(), slope_1_K.second(), way.second());
  const S returning = from.returning < S(2) * way.second() ? from.returning : S(0);
  const S r = from.phases.r_phase - turn.r_phase + returning;
  const S a = from.phases.austenite() - turn.austenite - returning;
  // z_M' = z_M + (a + r) (1 - r_A2M);  z_R' = z_R + back - r + (r + a (1 - r_A2R)) r_A2M
  const S stays = r + a * (S(1) - a2r.value);
  const Phases<S> z{from.phases.martensite + (a + r) * (S(1) - a2m.value),
                    from.phases.r_phase + returning * (S(1) - back.value) - r + stays * a2m.value};
  const PhaseRates<S> rates{
      -((a + r) * a2m.slope_1_K),
      stays * a2m.slope_1_K - a * a2r.slope_1_K * a2m.value - returning * back.slope_1_K};
  const S per_K = rates.martensite_1_K * by.martensite + rates.r_phase_1_K * by.r_phase;
  const S max_K = S(20);
  const S full_K = per_K < S(0) ? (goal - by.strain(z)) / per_K : S(0);
  const S warmer_K = full_K < -max_K ? -max_K : max_K < full_K ? max_K : full_K;
  point = {
      point.temperature_K + warmer_K,
      {z.martensite + rates.martensite_1_K * warmer_K, z.r_phase + rates.r_phase_1_K * warmer_K}};
}

}  // namespace smaservo
