#pragma once
// The modified Preisach operator: a wire as infinitely many relays over the temperature, whose
// distribution depends on the stress.
// Source: paper 003, eq. 2, figure 2 and section III; for the staircase, the wiping-out and the
// congruency property Mayergoyz, 'Mathematical Models of Hysteresis' (1991).
//
// A relay becomes austenite at α on heating and martensite again at β <= α on cooling. The only
// function of their distribution μ that is needed is F(α, β, σ), the weight of the relays in the
// triangle α' <= α, β' >= β: those that switch back between a reversal at α and β.
//
//   α |        . /      F stands on the grid nodes. Between them it is bilinear, so μ is constant
//     |------.  /       on each cell; on the diagonal's cells F is linear in α - β, so what is
//     |     |  /        there has no hysteresis. Between two stresses F is linear. μ itself is
//     |_____|_/         never formed: F is what reversal curves measure (003, section III).
//     |      /
//     |     / β         The staircase between the relays that are austenite and those that are
//                       martensite has its corners at the turning points that are still open.
//
// F is a share of martensite here; in 003 it is a strain: this F times the strain of full
// martensite less that of austenite, Material's strain_slopes().

#include <array>
#include <cstddef>
#include <cstdint>

#include "model/kinetics.hpp"
#include "model/scalar/order.hpp"

namespace smaservo::papers {

/// The turning points of an input that are still open, outermost first, alternately hot and cold;
/// the first is hot and is where the input came from. Each lies between the two before it.
template <class S, std::size_t depth>
struct Staircase {
  static_assert(4 <= depth && depth < 256);

  std::array<S, depth> turns;
  S input;
  std::uint8_t count;

  /// An input that came down from `from`, above all thresholds, to `to`.
  static constexpr Staircase cooled(const S& from, const S& to) {
    Staircase s{};
    s.turns[0] = from;
    s.input = to;
    s.count = 1;
    return s;
  }

  /// Whether the input is on its way up.
  constexpr bool heats() const { return count % 2 == 0; }
  /// The last turning point, from which the present branch starts.
  constexpr const S& newest() const { return turns[count - 1U]; }

  /// Returns whether the turning points have changed. If there are too many, the two neighbours
  /// that matter least are forgotten: `weight(hot, hotter, cold, warmer)` gives the weight of the
  /// relays that this switches, hot <= α < hotter and cold <= β < warmer. Forgetting the outermost
  /// ones would switch most of the relays.
  template <class Weight>
  constexpr bool move(const S& to, Weight weight) {
    const std::uint8_t before = count;
    const bool turns_here = heats() ? to < input : input < to;
    if (turns_here) {
      if (count == depth) {
        forget_least(weight);
      }
      turns[count++] = input;
    }
    input = to;
    while (count >= 3 && passes(turns[count - 2U])) {
      count = static_cast<std::uint8_t>(count - 2);
    }
    return turns_here || count != before;
  }

  /// Calls visit(sign, hot, cold) for each triangle whose signed sum is the martensite, except the
  /// triangle that ends at the input.
  template <class Visit>
  constexpr void each_settled(Visit visit) const {
    for (std::size_t i = 1; i < count; ++i) {
      if (i % 2 == 1) {
        visit(S(1), turns[i - 1], turns[i]);
      } else {
        visit(S(-1), turns[i], turns[i - 1]);
      }
    }
  }

 private:
  constexpr bool passes(const S& turn) const { return heats() ? !(input < turn) : !(turn < input); }

  template <class Weight>
  constexpr void forget_least(Weight weight) {
    std::size_t min = 1;
    S min_weight = S(0);
    for (std::size_t i = 1; i + 1 < depth; ++i) {
      const S& next = i + 2 < depth ? turns[i + 2] : input;
      const S here = i % 2 == 1 ? weight(turns[i + 1], turns[i - 1], turns[i], next)
                                : weight(next, turns[i], turns[i - 1], turns[i + 1]);
      if (i == 1 || here < min_weight) {
        min = i;
        min_weight = here;
      }
    }
    for (std::size_t i = min; i + 2 < depth; ++i) {
      turns[i] = turns[i + 2];
    }
    count = static_cast<std::uint8_t>(count - 2);
  }
};

/// All identified parameters, a plain value: 24 nodes and 8 stresses take 9 kB in float.
template <class S, std::size_t nodes = 24, std::size_t max_stresses = 8>
struct PreisachParams {
  /// F at each pair of nodes with hot > cold; the index is hot (hot - 1)/2 + cold.
  using Increments = std::array<S, nodes*(nodes - 1) / 2>;

  std::array<S, nodes> node_K;  ///< rising; all relays have both thresholds between the outer two
  /// The input is T - shift_K_Pa σ, and so are the nodes: stress raises all thresholds by the same
  /// amount and therefore switches relays. It is 0 in 003, where stress only changes the weights of
  /// the relays.
  S shift_K_Pa;
  std::size_t stress_count;               ///< 1..max_stresses; with 1, F is the same at any stress
  std::array<S, max_stresses> stress_Pa;  ///< rising, the first stress_count of them
  /// The increment between the outermost nodes is 1, and no cell of the grid has a negative weight,
  /// so that the fractions stay between 0 and 1.
  std::array<Increments, max_stresses> increments;

  /// Place in Increments of a pair of nodes, hot > cold.
  static constexpr std::size_t index(std::size_t hot, std::size_t cold) {
    return hot * (hot - 1) / 2 + cold;
  }
};

/// Remembers `memory_depth` turning points. The martensite of this model is all that elongates: for
/// a wire with an R-phase it includes a part of the R-phase.
template <class S, std::size_t nodes = 24, std::size_t max_stresses = 8,
          std::size_t memory_depth = 16>
struct Preisach {
  using Scalar = S;
  using Params = PreisachParams<S, nodes, max_stresses>;

  /// Staircase and fraction; trivially copyable.
  struct State {
    Drive<S> drive;
    Staircase<S, memory_depth> memory;
    S settled;     ///< martensite without the contribution of the branch that the input is on
    S martensite;  ///< fraction that the memory gives at the drive's stress
  };

  /// Whether the drive is in the identified range. Outside, the stress is clamped to it, and the
  /// relays are all austenite or all martensite.
  static constexpr bool valid(const Params& p, const Drive<S>& u) {
    const S x = input(p, u);
    return !(u.stress_Pa < p.stress_Pa[0]) && !(p.stress_Pa[p.stress_count - 1] < u.stress_Pa) &&
           !(x < p.node_K[0]) && !(p.node_K[nodes - 1] < x);
  }

  /// A wire that was cooled to this temperature at this stress from above all nodes.
  static State rest(const Params& p, const Drive<S>& u) {
    State s{};
    s.drive = u;
    s.memory = Staircase<S, memory_depth>::cooled(p.node_K[nodes - 1], clamped_input(p, u));
    s.settled = S(0);
    s.martensite = s.settled + branch(p, stress_place(p, u.stress_Pa), s);
    return s;
  }

  /// Exact for any step size on which T - shift σ does not reverse. A turning point does not
  /// remember the stress at which it was made: the same staircase is weighed at the stress of the
  /// step (003 eq. 2), so with shift_K_Pa = 0 unloading returns along the path of loading. Cost:
  /// one F on a branch at constant stress; at a new stress or at a reversal one for each turning
  /// point.
  static void advance(const Params& p, State& s, const Drive<S>& u) {
    const Place at = stress_place(p, u.stress_Pa);
    const bool turned = s.memory.move(
        clamped_input(p, u), [&](const S& hot, const S& hotter, const S& cold, const S& warmer) {
          return increment(p, at, hotter, cold) - increment(p, at, hot, cold) -
                 increment(p, at, hotter, warmer) + increment(p, at, hot, warmer);
        });
    if (turned || u.stress_Pa < s.drive.stress_Pa || s.drive.stress_Pa < u.stress_Pa) {
      s.settled = S(0);
      s.memory.each_settled([&](const S& sign, const S& hot, const S& cold) {
        s.settled += sign * increment(p, at, hot, cold);
      });
    }
    s.martensite = s.settled + branch(p, at, s);
    s.drive = u;
  }

  /// Where the last step went.
  static Drive<S> drive(const State& s) { return s.drive; }
  /// The fractions after it.
  static Phases<S> phases(const State& s) { return {s.martensite, S(0)}; }

  /// The slopes in the cell that the branch is in.
  static PhaseRates<S> rates(const Params& p, const State& s, Heading heading) {
    const bool heating = heading == Heading::heating;
    const S x = input(p, s.drive);
    if (heating ? x < p.node_K[0] || !(x < p.node_K[nodes - 1])
                : p.node_K[nodes - 1] < x || !(p.node_K[0] < x)) {
      return {S(0), S(0)};
    }
    const S& turn = s.memory.heats() == heating ? s.memory.newest() : s.memory.input;
    const Place at = stress_place(p, s.drive.stress_Pa);
    const Place hot = node_place(p, heating ? x : turn);
    const Place cold = node_place(p, heating ? turn : x);
    const Corners c = corners(p, at, hot.index, cold.index);
    if (heating) {
      const S per_cell = c.hotter - c.low + cold.share * (c.high - c.warmer - c.hotter + c.low);
      return {-per_cell / width_K(p, hot.index), S(0)};
    }
    const S per_cell = c.warmer - c.low + hot.share * (c.high - c.hotter - c.warmer + c.low);
    return {per_cell / width_K(p, cold.index), S(0)};
  }

  /// F(α, β, σ) in the nodes' temperatures, hot >= cold, both between the outermost nodes; the
  /// stress is clamped.
  static S increment(const Params& p, const S& hot_K, const S& cold_K, const S& stress_Pa) {
    return increment(p, stress_place(p, stress_Pa), hot_K, cold_K);
  }

 private:
  /// A position between a grid line and the next.
  struct Place {
    std::size_t index;
    S share;  ///< 0..1
  };
  /// F at the corners of a cell: at its lower α and β, at the upper α, at the upper β, at both
  /// upper ones.
  struct Corners {
    S low, hotter, warmer, high;
  };

  static constexpr S input(const Params& p, const Drive<S>& u) {
    return u.temperature_K -
           p.shift_K_Pa * clamp(u.stress_Pa, p.stress_Pa[0], p.stress_Pa[p.stress_count - 1]);
  }
  static constexpr S clamped_input(const Params& p, const Drive<S>& u) {
    return clamp(input(p, u), p.node_K[0], p.node_K[nodes - 1]);
  }
  static S width_K(const Params& p, std::size_t cell) {
    return p.node_K[cell + 1] - p.node_K[cell];
  }

  static Place stress_place(const Params& p, const S& stress_Pa) {
    if (p.stress_count == 1 || !(p.stress_Pa[0] < stress_Pa)) {
      return {0, S(0)};
    }
    std::size_t i = 0;
    while (i + 2 < p.stress_count && !(stress_Pa < p.stress_Pa[i + 1])) {
      ++i;
    }
    const S share = (stress_Pa - p.stress_Pa[i]) / (p.stress_Pa[i + 1] - p.stress_Pa[i]);
    return {i, S(1) < share ? S(1) : share};
  }
  static Place node_place(const Params& p, const S& x) {
    std::size_t low = 0;
    for (std::size_t high = nodes - 1; low + 1 < high;) {
      const std::size_t middle = (low + high) / 2;
      (x < p.node_K[middle] ? high : low) = middle;
    }
    return {low, (x - p.node_K[low]) / width_K(p, low)};
  }

  static S at_nodes(const Params& p, const Place& at, std::size_t hot, std::size_t cold) {
    const std::size_t i = Params::index(hot, cold);
    const S low = p.increments[at.index][i];
    return at.share > S(0) ? low + at.share * (p.increments[at.index + 1][i] - low) : low;
  }
  /// F is 0 on the diagonal, and beyond it F(β, α) = -F(α, β): so the cells on the diagonal are
  /// bilinear, too.
  static Corners corners(const Params& p, const Place& at, std::size_t hot, std::size_t cold) {
    if (hot == cold) {
      const S whole = at_nodes(p, at, hot + 1, cold);
      return {S(0), whole, -whole, S(0)};
    }
    return {at_nodes(p, at, hot, cold), at_nodes(p, at, hot + 1, cold),
            hot == cold + 1 ? S(0) : at_nodes(p, at, hot, cold + 1),
            at_nodes(p, at, hot + 1, cold + 1)};
  }

  static S increment(const Params& p, const Place& at, const S& hot_K, const S& cold_K) {
    const Place hot = node_place(p, hot_K);
    const Place cold = node_place(p, cold_K);
    const Corners c = corners(p, at, hot.index, cold.index);
    const S low = c.low + hot.share * (c.hotter - c.low);
    const S high = c.warmer + hot.share * (c.high - c.warmer);
    return low + cold.share * (high - low);
  }

  /// The martensite that the branch from the newest turning point to the input has added (less than
  /// 0: removed).
  static S branch(const Params& p, const Place& at, const State& s) {
    return s.memory.heats() ? -increment(p, at, s.memory.input, s.memory.newest())
                            : increment(p, at, s.memory.newest(), s.memory.input);
  }
};

}  // namespace smaservo::papers
