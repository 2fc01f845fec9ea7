#pragma once
// The three-phase model of paper 000: five transformation processes between martensite, R-phase
// and austenite, each with its own ihyp surface, competing for the phase they start from.
//
//   heating or falling stress:  M2A, R2A        cooling or rising stress:  A2M, A2R, R2M
//
// A process acts while the fraction s that its outer curve has left falls; it then leaves the
// ratio s(new)/s(old) of what it may convert (000, 'Switching the transformation direction' and
// the two sections after it; the ratio is the same as the scaling there).
//
// Return-point memory (ours; 000 leaves inner loops to future work). Plain scaling lets a ripple
// of the temperature walk the fractions away. With memory every reversal is kept as a turning
// point, and a branch that heads back to one converts only what was converted since, so that
// nothing of it is left on arrival: the ratio becomes (s(new) - s*)/(s(old) - s*), with s* the
// value at the turning point. With LoopOrder, C(s, q) takes the place of each s of M2A and A2M.
// Passing a turning point wipes its loop out. An outer branch is the same with its turning point at
// infinity, where s* = 0. model/README.md draws it.
//
// This file is long because step, memory and derivatives share their private parts.

#include <cmath>

#include "model/scalar/order.hpp"
#include "model/wire/three_phase/loop_order.hpp"
#include "model/wire/three_phase/three_phase_curves.hpp"
#include "model/wire/three_phase/turning_points.hpp"

namespace smaservo {

/// Remembers up to `memory_depth` open loops. If there are more, the one that is most nearly closed
/// is forgotten: a branch that would have passed it differs by no more than was left to close it.
template <class S, std::size_t memory_depth = 8>
struct ThreePhase {
  using Scalar = S;
  using Params = ThreePhaseParams<S>;

  using Curves = ThreePhaseCurves<S>;
  using Reverse = typename Curves::Reverse;
  using Forward = typename Curves::Forward;
  using Cut = typename Curves::Cut;

  /// A remembered reversal: a hot one from heating to cooling, a cold one from cooling to heating.
  /// `left` is what the outer curves had left there; the fractions are those of that moment.
  struct HotTurn {
    Reverse left;
    S martensite, r_phase;
  };
  /// Likewise; `returning` is what State::returning was.
  struct ColdTurn {
    Forward left;
    S austenite, r_phase, returning;
  };

  /// Fractions and history; trivially copyable.
  struct State {
    Drive<S> drive;
    Drive<S> reached;  ///< farthest point of the current heading; the fractions belong to it
    S martensite, r_phase;
    /// Austenite that becomes R-phase on the way to the newest cold turn, and stays R-phase.
    S returning;
    Reverse reverse;  ///< what the outer curves have left at `reached`; set when heating
    Forward forward;  ///< what the outer curves have left at `reached`; set when cooling
    Heading heading;
    TurningPoints<HotTurn, memory_depth> hot;
    TurningPoints<ColdTurn, memory_depth> cold;
  };

  /// Derivatives of the fractions after a step by those before it: m_r is the derivative of
  /// martensite by R-phase. The remembered turning points are assumed to change along with them as
  /// in correct(). The derivative by the temperature after the step is rates() after it; the
  /// derivative by the temperature before is minus this matrix times rates() before: exact on outer
  /// branches, and on inner ones as long as the step is small compared to the loop.
  struct Transfer {
    S m_m, m_r, r_m, r_r;
  };

  /// The derivatives of a step. `rates` hold after the step; the slopes are those of the outer
  /// curves at `reached`, and only those of the current heading are set.
  struct Tangent {
    Transfer transfer;
    PhaseRates<S> rates;
    Reverse reverse_1_K;
    Forward forward_1_K;
  };

  /// A wire that was cooled to this temperature at this stress from far above.
  static State rest(const Params& p, const Drive<S>& u) {
    State s;
    start(p, s, u, {S(0), S(0)});
    const Forward now = s.forward;
    // One step from infinite temperature: exact if R2M shares A2M's surface, and with a surface of
    // its own close enough for a state of which nothing is known.
    s.forward = {Pair<S>(S(1)), S(1)};
    cool<true>(p, s, now);
    return s;
  }

  /// A state with given fractions (on the simplex), as if cooled to this drive.
  static State with_phases(const Params& p, const Drive<S>& u, const Phases<S>& phases) {
    State s;
    start(p, s, u, phases);
    return s;
  }
  /// Like with_phases(), but in place: a small stack has no room for states.
  static void start(const Params& p, State& s, const Drive<S>& u, const Phases<S>& phases) {
    s.hot.start({{S(0), S(0)}, S(0), S(0)});
    s.cold.start({{Pair<S>(S(0)), S(0)}, S(0), S(0), S(0)});
    s.drive = u;
    s.reached = u;
    s.martensite = phases.martensite;
    s.r_phase = phases.r_phase;
    s.returning = S(0);
    s.heading = Heading::cooling;
    s.reverse = {S(0), S(0)};
    s.forward = Curves::forward_left(p, u);
  }

  /// Exact for any step size at one stress if the processes share their surfaces as in 000; with a
  /// separate R2M the error is of second order in the step, and of first order if a step at another
  /// stress passes a turning point. Cost: one curve when heating, two when cooling, all three at a
  /// reversal.
  static void advance(const Params& p, State& s, const Drive<S>& u) {
    move<false>(p, AtStress{p, u.stress_Pa}, s, u);
  }
  /// advance(), and the derivatives of that step.
  static Tangent advance_linearised(const Params& p, State& s, const Drive<S>& u) {
    return move<true>(p, AtStress{p, u.stress_Pa}, s, u);
  }

  /// Applies an observer's correction after a step: the wire was warmer by `warmer_K` all along
  /// this branch and has the fractions `to` (on the simplex). A correction of a fraction by 1 %
  /// also corrects it by 1 % at all remembered turning points, which stay on the simplex. A small
  /// shift of the temperature follows the step's tangents; a larger one evaluates the curves again.
  static void correct(const Params& p, State& s, const Tangent& tangent, const S& warmer_K,
                      const Phases<S>& to) {
    const S m = scale(to.martensite, s.martensite);
    const S r = scale(to.r_phase, s.r_phase);
    const S a = scale(to.austenite(), phases(s).austenite());
    for (HotTurn& turn : s.hot) {
      turn.martensite = min(turn.martensite * m, S(1));
      turn.r_phase = min(turn.r_phase * r, S(1) - turn.martensite);
    }
    S outer = S(0);  // no more R-phase can return than at the turning point before
    for (ColdTurn& turn : s.cold) {
      // R-phase that the turning point has beyond the present state is austenite now.
      const S more = turn.r_phase - s.r_phase;
      turn.austenite = min(turn.austenite * a, S(1));
      turn.r_phase = min(to.r_phase + more * (more < S(0) ? r : a), S(1) - turn.austenite);
      turn.returning = min(turn.returning * a, outer);
      outer = turn.r_phase;
    }
    s.returning = min(s.returning * a, outer);
    s.martensite = to.martensite;
    s.r_phase = to.r_phase;
    s.drive.temperature_K += warmer_K;
    s.reached.temperature_K += warmer_K;
    const bool small = warmer_K < S(0.02) && S(-0.02) < warmer_K;
    if (s.heading == Heading::heating) {
      const S m2a = s.reverse.m2a + warmer_K * tangent.reverse_1_K.m2a;
      s.reverse = small && !p.separate_r2a ? Reverse{m2a, m2a} : Curves::reverse_left(p, s.reached);
    } else {
      const Pair<S> both = s.forward.a2m_a2r + Pair<S>(warmer_K) * tangent.forward_1_K.a2m_a2r;
      s.forward = small && !p.separate_r2m ? Forward{both, both.first()}
                                           : Curves::forward_left(p, s.reached);
    }
  }

  /// The curves at one stress, for many steps there.
  static Cut cut(const Params& p, const S& stress_Pa) { return Curves::cut(p, stress_Pa); }
  /// Like advance() above with a cut computed before; a quarter cheaper.
  static void advance(const Params& p, const Cut& cut, State& s, const S& temperature_K) {
    move<false>(p, AtCut{cut}, s, {temperature_K, cut.stress_Pa});
  }

  // The parts of a step, for many wires side by side: three_phase_row.hpp evaluates the curves of
  // all wires at once and passes the results to these functions.

  /// Curves of the processes of one heading: M2A and R2A, or A2M and A2R.
  static Isobar<Pair<S>> curves(const Params& p, const S& stress_Pa, Heading heading) {
    const AtStress at{p, stress_Pa};
    return heading == Heading::heating ? pair_isobars(at.m2a(), at.r2a()) : at.a2m_a2r();
  }
  /// What these processes have left at the farthest point.
  static Pair<S> left(const State& s) {
    return s.heading == Heading::heating ? Pair<S>(s.reverse.m2a, s.reverse.r2a)
                                         : s.forward.a2m_a2r;
  }
  /// advance(), where `left` is what curves() of the state's heading have left at `u`.
  static void advance(const Params& p, State& s, const Drive<S>& u, const Pair<S>& left) {
    move<false>(p, typename Curves::AtNext{{p, u.stress_Pa}, left}, s, u);
  }
  /// Whether rates() may differ from zero.
  static bool acts(const State& s, Heading heading) {
    return heading == s.heading && !(s.drive.temperature_K < s.reached.temperature_K) &&
           !(s.reached.temperature_K < s.drive.temperature_K);
  }
  /// rates() of a state that acts, given the slopes of curves() at left() and at its stress.
  static PhaseRates<S> rates(const Params& p, const State& s, const Pair<S>& slopes_1_K) {
    const AtStress at{p, s.reached.stress_Pa};
    return s.heading == Heading::heating
               ? rates(p, s, Reverse{slopes_1_K.first(), slopes_1_K.second()})
               : rates(p, s, Curves::forward_slopes(p, at, s.forward, slopes_1_K));
  }

  /// The order in which a branch of M2A or A2M transforms, if the other one of them had this left
  /// at the turning point behind the branch.
  static LoopOrder<S> loop_order(const Params& p, const S& left) {
    if (p.memory == Memory::plain) {
      return {S(0), S(1)};
    }
    // Rounding may have left nothing converted; the branch would then lead nowhere.
    const S least = S(1e-6);
    const S q = S(1) - left;
    return {p.loop_odds - S(1), q < least ? least : q};
  }

  /// Where the last step went.
  static Drive<S> drive(const State& s) { return s.drive; }
  /// The fractions after it.
  static Phases<S> phases(const State& s) { return {s.martensite, s.r_phase}; }

  /// Zero if the next small step transforms nothing: it goes against the heading, or has not yet
  /// returned to the farthest point.
  static PhaseRates<S> rates(const Params& p, const State& s, Heading heading) {
    if (!acts(s, heading)) {
      return {S(0), S(0)};
    }
    const AtStress at{p, s.reached.stress_Pa};
    return heading == Heading::heating ? rates(p, s, Curves::slopes(p, at, s.reverse))
                                       : rates(p, s, Curves::slopes(p, at, s.forward));
  }

 private:
  using AtStress = typename Curves::AtStress;
  using AtCut = typename Curves::AtCut;

  template <bool linearise, class Isobars>
  static Tangent move(const Params& p, const Isobars& at, State& s, const Drive<S>& u) {
    s.drive = u;
    Transfer transfer{S(1), S(0), S(0), S(1)};
    bool moved = false;
    if (s.heading == Heading::heating) {
      const Reverse now = Curves::reverse_next(p, at, u.temperature_K);
      moved = Curves::falls(p, now, s.reverse);
      if (moved) {
        transfer = heat<linearise>(p, s, now);
      } else if (p.smallest_reversal_K < returned_K(p, s)) {
        moved = turn_to_cooling(p, at, s);
      }
    } else {
      const Forward now = Curves::forward_next(p, at, u.temperature_K);
      moved = Curves::falls(p, now, s.forward);
      if (moved) {
        transfer = cool<linearise>(p, s, now);
      } else if (p.smallest_reversal_K < returned_K(p, s)) {
        moved = turn_to_heating(p, at, s);
      }
    }
    if (!moved) {
      follow_stress(p, s);
    }
    if constexpr (!linearise) {
      return {};
    }
    return s.heading == Heading::heating ? heating_tangent(p, at, s, transfer, moved)
                                         : cooling_tangent(p, at, s, transfer, moved);
  }

  template <class Isobars>
  static Tangent heating_tangent(const Params& p, const Isobars& at, const State& s,
                                 const Transfer& transfer, bool moved) {
    const Reverse slope = Curves::slopes(p, at, s.reverse);
    return {transfer, moved ? rates(p, s, slope) : PhaseRates<S>{S(0), S(0)}, slope, Forward{}};
  }

  template <class Isobars>
  static Tangent cooling_tangent(const Params& p, const Isobars& at, const State& s,
                                 const Transfer& transfer, bool moved) {
    const Forward slope = Curves::slopes(p, at, s.forward);
    return {transfer, moved ? rates(p, s, slope) : PhaseRates<S>{S(0), S(0)}, Reverse{}, slope};
  }

  static S scale(const S& to, const S& from) { return S(1e-6) < from ? to / from : S(0); }
  static S share(const S& part, const S& whole) { return S(1e-6) < whole ? part / whole : S(1); }

  /// The distance by which the drive has come back from its farthest point, as a temperature.
  static S returned_K(const Params& p, const State& s) {
    const S cooler = s.reached.temperature_K - s.drive.temperature_K;
    const S from = s.reached.stress_Pa;
    const S to = s.drive.stress_Pa;
    return s.heading == Heading::heating
               ? cooler + p.m2a.start_shift_K(from, to)
               : -cooler - p.a2m_a2r.start_shift_K(Pair<S>(from), Pair<S>(to)).first();
  }

  /// When temperature and stress change together so that nothing transforms, the farthest point
  /// follows them, lest the processes of the other direction begin where the wire was long ago.
  static void follow_stress(const Params& p, State& s) {
    const S change_Pa = s.drive.stress_Pa - s.reached.stress_Pa;
    const S by_Pa = change_Pa < S(0) ? -change_Pa : change_Pa;
    const S returned = returned_K(p, s);
    // Changes below 2 MPa are ignored: they may be noise of a load cell, which would drag the
    // farthest point along.
    if (S(2e6) < by_Pa || returned < S(0)) {
      const S back_K = positive(returned);
      s.reached = {s.drive.temperature_K + (s.heading == Heading::heating ? back_K : -back_K),
                   s.drive.stress_Pa};
    }
  }

  static bool has_order(const Params& p) { return p.loop_odds < S(1) || S(1) < p.loop_odds; }
  /// ratio() of a process whose pool transforms in an order. Not inline: most wires have none.
  [[gnu::noinline]] static S ordered_ratio(const LoopOrder<S>& order, const S& now, const S& before,
                                           const S& target) {
    return now < before ? ratio(order(now), order(before), order(target)) : S(1);
  }
  static LoopOrder<S> order_of_heating(const Params& p, const State& s) {
    return loop_order(p, s.cold.newest().left.a2m_a2r.first());
  }
  static LoopOrder<S> order_of_cooling(const Params& p, const State& s) {
    return loop_order(p, s.hot.newest().left.m2a);
  }

  /// The share of a pool that a step leaves: 1 if the process does not act, 0 on arrival at the
  /// turning point.
  static S ratio(const S& now, const S& before, const S& target) {
    if (!(now < before)) {
      return S(1);
    }
    return target < now ? (now - target) / (before - target) : S(0);
  }

  // At one stress all processes of a direction reach a turning point together. If the stress has
  // changed since, M2A and A2M decide when it has been passed; a process that has not reached it by
  // then goes on towards the next one, and a process whose turning point is not ahead keeps the
  // ratio of M2A or A2M. So nothing jumps.
  static bool ahead(const S& before, const S& target) { return target < before; }
  static bool late(const S& now, const S& before, const S& target) {
    return target < now && ahead(before, target);
  }

  static void close_innermost_loop(State& s) {
    s.hot.pop();
    s.cold.pop();
  }
  /// How far two states are apart, from the fractions of two phases in each.
  static S apart(const S& one, const S& other, const S& one_r, const S& other_r) {
    const S by = one - other;
    const S by_r = one_r - other_r;
    return (by < S(0) ? -by : by) + (by_r < S(0) ? -by_r : by_r);
  }
  /// Makes room in a full memory, at the end of a cooling branch, where each hot turn has a cold
  /// one before it. Between two cold turns that are almost the same state lies a loop that is
  /// almost closed, and likewise between two hot ones; the closest two of all become one, and the
  /// turn between them goes. (Forgetting the outermost loop instead makes a hot wire under noise
  /// convert anew with every ripple; forgetting the innermost sends small loops along the branch of
  /// a large one. Either let a held wire jump by 20 % of its stroke.)
  static void forget_narrowest_loop(State& s) {
    std::size_t cold = 1;
    std::size_t hot = 1;
    S least = S(2);
    const auto take = [&](const S& width, std::size_t cold_turn, std::size_t hot_turn) {
      if (width < least) {
        least = width;
        cold = cold_turn;
        hot = hot_turn;
      }
    };
    for (std::size_t i = 1; i <= s.cold.size(); ++i) {
      const ColdTurn& turn = s.cold.at(i);
      const HotTurn& before = s.hot.at(i - 1);
      const HotTurn& after = s.hot.at(i);
      const bool is_last = i == s.cold.size();
      take(apart(before.martensite, after.martensite, before.r_phase, after.r_phase), i,
           i == 1 ? 1 : i - 1);
      take(apart(turn.austenite, is_last ? phases(s).austenite() : s.cold.at(i + 1).austenite,
                 turn.r_phase, is_last ? s.r_phase : s.cold.at(i + 1).r_phase),
           i, i);
    }
    // What returned on the way to the forgotten cold turn returns on the way to the one before it.
    const S returning = s.cold.at(cold).returning;
    const S r_phase = s.cold.at(cold - 1).r_phase;
    s.hot.erase(hot);
    s.cold.erase(cold);
    S& next = cold <= s.cold.size() ? s.cold.begin()[cold - 1].returning : s.returning;
    next = min(next + returning, r_phase);
  }

  template <class Isobars>
  static bool turn_to_heating(const Params& p, const Isobars& at, State& s) {
    if (p.memory == Memory::return_point) {
      if (s.cold.full()) {
        forget_narrowest_loop(s);
      }
      s.cold.push({s.forward, phases(s).austenite(), s.r_phase, s.returning});
    }
    s.heading = Heading::heating;
    s.reverse = Curves::reverse_left(p, s.reached);
    // Turning points that the stress has passed meanwhile are no longer targets.
    while (s.hot.size() > 0 && !ahead(s.reverse.m2a, s.hot.newest().left.m2a)) {
      close_innermost_loop(s);
    }
    const Reverse now = Curves::reverse_left(p, at, s.drive.temperature_K);
    const bool moves = Curves::falls(p, now, s.reverse);
    if (moves) {
      heat<true>(p, s, now);
    }
    return moves;
  }

  template <class Isobars>
  static bool turn_to_cooling(const Params& p, const Isobars& at, State& s) {
    if (p.memory == Memory::return_point) {
      s.hot.push({s.reverse, s.martensite, s.r_phase});
    }
    s.heading = Heading::cooling;
    s.forward = Curves::forward_left(p, s.reached);
    while (s.cold.size() > 0 &&
           !ahead(s.forward.a2m_a2r.first(), s.cold.newest().left.a2m_a2r.first())) {
      close_innermost_loop(s);
    }
    for (ColdTurn& turn : s.cold) {
      const Pair<S> left = turn.left.a2m_a2r;
      turn.left.a2m_a2r = Pair<S>(left.first(), min(left.second(), s.forward.a2m_a2r.second()));
    }
    s.returning = by_a2r(s, positive(s.cold.newest().r_phase - s.r_phase));
    const Forward now = Curves::forward_left(p, at, s.drive.temperature_K);
    const bool moves = Curves::falls(p, now, s.forward);
    if (moves) {
      cool<true>(p, s, now);
    }
    return moves;
  }

  // Reversals and starts use heat<true>() and cool<true>() although they need no derivatives: so
  // the program of a microcontroller's observer contains only one version of each.

  // 000, 'Heating process for three phase fractions': M2A and R2A are independent.
  template <bool linearise>
  static Transfer heat(const Params& p, State& s, const Reverse& now) {
    const Phases<S> before = phases(s);
    while (s.hot.size() > 0 && !(s.hot.newest().left.m2a < now.m2a)) {
      const HotTurn& passed = s.hot.newest();
      s.martensite = min(s.martensite, passed.martensite);
      if (!late(now.r2a, s.reverse.r2a, passed.left.r2a)) {
        s.r_phase = min(s.r_phase, passed.r_phase);
        s.reverse.r2a = min(s.reverse.r2a, passed.left.r2a);
      }
      s.reverse.m2a = passed.left.m2a;
      close_innermost_loop(s);
    }
    // z_M *= r_M2A;  z_R *= r_R2A, above the target
    const HotTurn& target = s.hot.newest();
    const S r_m2a = has_order(p) ? ordered_ratio(order_of_heating(p, s), now.m2a, s.reverse.m2a,
                                                 target.left.m2a)
                                 : ratio(now.m2a, s.reverse.m2a, target.left.m2a);
    const S r_r2a = p.separate_r2a && ahead(s.reverse.r2a, target.left.r2a)
                        ? ratio(now.r2a, s.reverse.r2a, target.left.r2a)
                        : r_m2a;
    s.martensite = target.martensite + (s.martensite - target.martensite) * r_m2a;
    s.r_phase = target.r_phase + (s.r_phase - target.r_phase) * r_r2a;
    s.reverse = {min(now.m2a, s.reverse.m2a), min(now.r2a, s.reverse.r2a)};
    s.reached = s.drive;
    if constexpr (linearise) {
      return {share(s.martensite, before.martensite), S(0), S(0), share(s.r_phase, before.r_phase)};
    }
    return {};
  }

  // 000, 'Cooling process for three phase fractions': A2M and A2R compete for the austenite, R2M
  // follows. Of the austenite above the target, the part `returning` becomes R-phase and stays
  // R-phase; the rest transforms to martensite, directly or through the R-phase.
  template <bool linearise>
  static Transfer cool(const Params& p, State& s, const Forward& now) {
    const Phases<S> start = phases(s);
    S lost_r = S(0);
    while (s.cold.size() > 0 && !(s.cold.newest().left.a2m_a2r.first() < now.a2m_a2r.first())) {
      lost_r += pass_cold_turn(s, now);
    }
    [[maybe_unused]] const S excess_r = positive(s.r_phase - s.cold.newest().r_phase);
    return_r_phase(s, now);
    pass_by_a2r(s, now);
    const ColdTurn& target = s.cold.newest();
    // r: R-phase that must transform (less than 0: R-phase that is still missing and comes in step
    // with martensite); a: austenite that must transform to martensite.
    const S r = s.r_phase - target.r_phase + s.returning;
    const S a = phases(s).austenite() - target.austenite - s.returning;
    // r_A2M towards the target, r_A2R without one
    const Pair<S> goal(target.left.a2m_a2r.first(), S(0));
    const Pair<S> before = s.forward.a2m_a2r;
    const auto acts = now.a2m_a2r < before;
    const Pair<S> ratios = select(acts, (now.a2m_a2r - goal) / (before - goal), Pair<S>(S(1)));
    const S r_a2m = has_order(p) ? ordered_ratio(order_of_cooling(p, s), now.a2m_a2r.first(),
                                                 before.first(), goal.first())
                                 : ratios.first();
    const S r_a2r = ratios.second();
    S stays_r = r_a2m;     // share of r that is left
    S on_the_way = r_a2m;  // share of a that is left as austenite or R-phase; exact for any step
    if (p.separate_r2m && ahead(s.forward.r2m, target.left.r2m)) {
      // Strang's symmetric splitting: half of A2R before the others, half after.
      using std::sqrt;
      const S half = sqrt(r_a2r);
      const S r_r2m = ratio(now.r2m, s.forward.r2m, target.left.r2m);
      on_the_way = (S(1) - half) * r_r2m + half * r_a2m;
      stays_r = r < S(0) ? r_a2m : r_r2m;
    }
    const S rest = min(r * stays_r + a * on_the_way, r + a);
    // z_M += z_A (1 - r_A2M) + z_R (1 - r_R2M);  z_R += z_A (1 - r_A2R)
    s.martensite += a + r - rest;
    s.r_phase = min(positive(s.r_phase + (rest - r - a * r_a2r * r_a2m)), S(1) - s.martensite);
    s.forward.a2m_a2r = select(acts, now.a2m_a2r, before);
    s.forward.r2m = p.separate_r2m ? min(now.r2m, s.forward.r2m) : s.forward.a2m_a2r.first();
    s.reached = s.drive;
    if constexpr (linearise) {
      // Of the austenite before the step, the share `stays` is still austenite and the share g is
      // R-phase now; of the R-phase before, the share b is still R-phase.
      lost_r += excess_r * (S(1) - stays_r);
      const S a0 = start.austenite();
      const S stays = share(phases(s).austenite(), a0);
      const S b = share(start.r_phase - lost_r, start.r_phase);
      const S g = min(share(s.r_phase - start.r_phase + lost_r, a0), S(1) - stays);
      return {stays + g, stays + g - b, -g, b - g};
    }
    return {};
  }

  /// The part of the R-phase r that returns by A2R: all of it, or none if A2R has less than r/2 of
  /// its curve left before the turning point, since the return would be a jump there. It then
  /// returns in step with martensite.
  static S by_a2r(const State& s, const S& r) {
    const S way = s.forward.a2m_a2r.second() - s.cold.newest().left.a2m_a2r.second();
    return r < S(2) * way ? r : S(0);
  }

  /// Returns the R-phase that passing the turning point has taken.
  static S pass_cold_turn(State& s, const Forward& now) {
    const ColdTurn passed = s.cold.newest();
    const S a2r = s.forward.a2m_a2r.second();
    const S a2r_passed = passed.left.a2m_a2r.second();
    const bool a2r_late = late(now.a2m_a2r.second(), a2r, a2r_passed);
    const bool r2m_late = late(now.r2m, s.forward.r2m, passed.left.r2m);
    const S staying = a2r_late ? s.returning : S(0);
    const S excess_r = s.r_phase - (passed.r_phase - s.returning);
    const S a = positive(phases(s).austenite() - passed.austenite - s.returning);
    const S leaves_r = r2m_late ? S(0) : positive(excess_r);
    const S comes_r = min(a, positive(-excess_r));
    s.martensite = s.martensite + (a - comes_r) + leaves_r;
    s.r_phase = s.r_phase + (s.returning - staying) + comes_r - leaves_r;
    close_innermost_loop(s);
    const S a2r_from = a2r_late ? a2r : min(a2r, a2r_passed);
    s.forward = {Pair<S>(passed.left.a2m_a2r.first(), a2r_from),
                 r2m_late ? s.forward.r2m : min(s.forward.r2m, passed.left.r2m)};
    if (a2r_from < s.cold.newest().left.a2m_a2r.second()) {
      move_by_a2r(s.cold.newest(), a2r_from);
    }
    s.returning = by_a2r(s, min(passed.returning + staying, s.cold.newest().r_phase));
    return leaves_r;
  }

  /// If A2R passes a turning point before A2M does, the austenite that was to stay there becomes
  /// R-phase like all other austenite.
  static void pass_by_a2r(State& s, const Forward& now) {
    ColdTurn& turn = s.cold.newest();
    const S a2r = now.a2m_a2r.second();
    if (a2r < turn.left.a2m_a2r.second()) {
      const S stays = min(turn.austenite, phases(s).austenite());
      s.r_phase += stays * move_by_a2r(turn, a2r);
    }
  }
  /// Returns the share of the turning point's austenite that has become R-phase.
  static S move_by_a2r(ColdTurn& turn, const S& a2r) {
    const Pair<S> left = turn.left.a2m_a2r;
    const S share = S(1) - a2r / left.second();
    const S converted = share * turn.austenite;
    turn.austenite -= converted;
    turn.r_phase += converted;
    turn.left.a2m_a2r = Pair<S>(left.first(), a2r);
    return share;
  }

  static void return_r_phase(State& s, const Forward& now) {
    if (!ahead(s.forward.a2m_a2r.second(), s.cold.newest().left.a2m_a2r.second())) {
      s.returning = S(0);
    }
    if (S(0) < s.returning) {
      const S back = s.returning * (S(1) - ratio(now.a2m_a2r.second(), s.forward.a2m_a2r.second(),
                                                 s.cold.newest().left.a2m_a2r.second()));
      s.returning -= back;
      s.r_phase += back;
    }
  }

  static PhaseRates<S> rates(const Params& p, const State& s, const Reverse& slope) {
    const LoopOrder<S> order = order_of_heating(p, s);
    const HotTurn& target = s.hot.newest();
    const bool own = p.separate_r2a && ahead(s.reverse.r2a, target.left.r2a);
    const S m = positive(s.martensite - target.martensite);
    const S r = positive(s.r_phase - target.r_phase);
    return {flow(order, slope.m2a, s.reverse.m2a, target.left.m2a, m),
            own ? flow(slope.r2a, s.reverse.r2a, target.left.r2a, r)
                : flow(order, slope.m2a, s.reverse.m2a, target.left.m2a, r)};
  }
  static PhaseRates<S> rates(const Params& p, const State& s, const Forward& slope) {
    const LoopOrder<S> order = order_of_cooling(p, s);
    const ColdTurn& target = s.cold.newest();
    const Pair<S> left = s.forward.a2m_a2r;
    const Pair<S> goal = target.left.a2m_a2r;
    const S r = s.r_phase - target.r_phase + s.returning;
    const S a = positive(phases(s).austenite() - target.austenite - s.returning);
    const bool own = p.separate_r2m && !(r < S(0)) && ahead(s.forward.r2m, target.left.r2m);
    const S a2m = flow(order, slope.a2m_a2r.first(), left.first(), goal.first(), a);
    const S r2m = own ? flow(slope.r2m, s.forward.r2m, target.left.r2m, r)
                      : flow(order, slope.a2m_a2r.first(), left.first(), goal.first(), r);
    S a2r = flow(slope.a2m_a2r.second(), left.second(), S(0), a);
    if (S(0) < s.returning) {
      a2r += flow(slope.a2m_a2r.second(), left.second(), goal.second(), s.returning);
    }
    // Per kelvin of rising temperature, so gains of cooling are negative.
    return {-a2m - r2m, r2m - a2r};
  }

  /// The rate at which a pool is consumed, per kelvin. Closer than 0.05 K to the turning point the
  /// rate is that at 0.05 K: an observer's correction may have left more in the pool than the rest
  /// of the way can transform.
  static S flow(const S& slope, const S& left, const S& target, const S& pool) {
    const S room = left - target;
    const S shortest = S(0.05) * (slope < S(0) ? -slope : slope);
    const S longer = room < shortest ? shortest : room;
    return S(0) < longer ? slope * pool / longer : S(0);
  }
  static S flow(const LoopOrder<S>& order, const S& slope, const S& left, const S& target,
                const S& pool) {
    return order.matters() ? flow(order.slope(left) * slope, order(left), order(target), pool)
                           : flow(slope, left, target, pool);
  }
};

}  // namespace smaservo
