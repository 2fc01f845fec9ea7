#pragma once
// The outer curves of the three-phase model's five processes: the share that each has left at a
// temperature and a stress. Source: paper 000, 'Stress dependence of the material parameters';
// three_phase.hpp steps along them.

#include "model/wire/three_phase/surface.hpp"

namespace smaservo {

/// How inner loops behave: `plain` is the scaling of paper 000, `return_point` returns to
/// remembered turning points (three_phase.hpp).
enum class Memory : unsigned char { plain, return_point };

template <class S>
struct ThreePhaseParams {
  Surface<S> m2a;
  Surface<Pair<S>> a2m_a2r;   ///< A2M in the first lane, A2R in the second: needed together
  Surface<S> r2a;             ///< used when separate_r2a
  Surface<S> r2m;             ///< used when separate_r2m
  bool separate_r2a = false;  ///< R2A has a surface of its own; 000 shares M2A's
  bool separate_r2m = false;  ///< R2M has a surface of its own; 000 shares A2M's
  Memory memory = Memory::return_point;
  /// Only a reversal larger than this counts; until then nothing transforms. Then the part that was
  /// held back follows at once, so larger motions at one stress do not depend on it.
  S smallest_reversal_K = S(0);
  /// θ of LoopOrder, in loop_odds_range: how strongly the order in which the wire's parts leave
  /// martensite depends on the order in which they became it. 1: not at all, as in 000. Without
  /// memory it has no effect.
  S loop_odds = S(1);
};

template <class S>
struct ThreePhaseCurves {
  using Params = ThreePhaseParams<S>;

  /// The shares s that the outer curves of one direction's processes have left.
  struct Reverse {
    S m2a, r2a;
  };
  struct Forward {
    Pair<S> a2m_a2r;
    S r2m;
  };

  /// The surfaces cut at one stress, for many steps at that stress.
  struct Cut {
    S stress_Pa;
    Isobar<S> m2a, r2a, r2m;
    Isobar<Pair<S>> a2m_a2r;
  };

  // Sources of the isobars: cut when they are needed (AtStress), or cut before (AtCut).
  struct AtStress {
    const Params& p;
    S stress_Pa;
    Isobar<S> m2a() const { return isobar(p.m2a, stress_Pa); }
    Isobar<S> r2a() const { return isobar(p.separate_r2a ? p.r2a : p.m2a, stress_Pa); }
    Isobar<S> r2m() const { return isobar(p.r2m, stress_Pa); }
    Isobar<Pair<S>> a2m_a2r() const { return isobar(p.a2m_a2r, Pair<S>(stress_Pa)); }
  };
  struct AtCut {
    const Cut& cut;
    const Isobar<S>& m2a() const { return cut.m2a; }
    const Isobar<S>& r2a() const { return cut.r2a; }
    const Isobar<S>& r2m() const { return cut.r2m; }
    const Isobar<Pair<S>>& a2m_a2r() const { return cut.a2m_a2r; }
  };

  /// AtStress with the shares that the heading's processes have left at the end of the step.
  struct AtNext : AtStress {
    Pair<S> left;
  };

  template <class Isobars>
  static Reverse reverse_left(const Params& p, const Isobars& at, const S& temperature_K) {
    const S m2a = at.m2a().remaining(temperature_K);
    return {m2a, p.separate_r2a ? at.r2a().remaining(temperature_K) : m2a};
  }
  static Reverse reverse_left(const Params& p, const Drive<S>& u) {
    return reverse_left(p, AtStress{p, u.stress_Pa}, u.temperature_K);
  }

  template <class Isobars>
  static Forward forward_left(const Params& p, const Isobars& at, const S& temperature_K) {
    return forward_left(p, at, temperature_K, at.a2m_a2r().remaining(Pair<S>(temperature_K)));
  }
  template <class Isobars>
  static Forward forward_left(const Params& p, const Isobars& at, const S& temperature_K,
                              const Pair<S>& a2m_a2r) {
    return {a2m_a2r, p.separate_r2m ? at.r2m().remaining(temperature_K) : a2m_a2r.first()};
  }
  static Forward forward_left(const Params& p, const Drive<S>& u) {
    return forward_left(p, AtStress{p, u.stress_Pa}, u.temperature_K);
  }

  // The curves at the end of a step, in the heading before the step.
  template <class Isobars>
  static Reverse reverse_next(const Params& p, const Isobars& at, const S& temperature_K) {
    return reverse_left(p, at, temperature_K);
  }
  static Reverse reverse_next(const Params& /*p*/, const AtNext& at, const S& /*temperature_K*/) {
    return {at.left.first(), at.left.second()};
  }
  template <class Isobars>
  static Forward forward_next(const Params& p, const Isobars& at, const S& temperature_K) {
    return forward_left(p, at, temperature_K);
  }
  static Forward forward_next(const Params& p, const AtNext& at, const S& temperature_K) {
    return forward_left(p, at, temperature_K, at.left);
  }

  static bool falls(const Params& p, const Reverse& now, const Reverse& before) {
    return now.m2a < before.m2a || (p.separate_r2a && now.r2a < before.r2a);
  }
  static bool falls(const Params& p, const Forward& now, const Forward& before) {
    return any(now.a2m_a2r < before.a2m_a2r) || (p.separate_r2m && now.r2m < before.r2m);
  }

  template <class Isobars>
  static Reverse slopes(const Params& p, const Isobars& at, const Reverse& left) {
    const S m2a = at.m2a().remaining_1_K(left.m2a);
    return {m2a, p.separate_r2a ? at.r2a().remaining_1_K(left.r2a) : m2a};
  }
  template <class Isobars>
  static Forward slopes(const Params& p, const Isobars& at, const Forward& left) {
    return forward_slopes(p, at, left, at.a2m_a2r().remaining_1_K(left.a2m_a2r));
  }
  template <class Isobars>
  static Forward forward_slopes(const Params& p, const Isobars& at, const Forward& left,
                                const Pair<S>& a2m_a2r) {
    return {a2m_a2r, p.separate_r2m ? at.r2m().remaining_1_K(left.r2m) : a2m_a2r.first()};
  }

  static Cut cut(const Params& p, const S& stress_Pa) {
    const AtStress at{p, stress_Pa};
    return {stress_Pa, at.m2a(), at.r2a(), at.r2m(), at.a2m_a2r()};
  }
};

}  // namespace smaservo
