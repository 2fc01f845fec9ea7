#pragma once
// The order in which the parts of a wire transform back after a reversal.
//
// In paper 000 a branch converts the same share of any pool: which parts of the wire became
// martensite first says nothing about which of them goes back first. A real wire remembers which of
// its parts transformed: those that became martensite last, at the lowest temperature, tend to
// become austenite first. So every part has two ranks. The one in A2M is the share u that A2M's
// outer curve has converted when the part becomes martensite; the one in M2A is the share v that
// M2A's outer curve has left when the part becomes austenite. Of the parts with u < q, the share
// C(v, q) of the whole wire is still martensite where M2A's outer curve has v left; C is the joint
// distribution of the ranks. This is a model of Preisach's kind with two outer curves and a copula.
//
// Source of the copula: Plackett 1965, 'A class of bivariate distributions'. It has one parameter,
// the odds ratio θ, and is explicit in both directions:
//
//   C (1 - v - q + C) = θ (v - C) (q - C)
//
// θ = 1 is paper 000: C = v q. With a great θ, C approaches min(v, q): what transformed last goes
// back first, and a loop within the hysteresis does nothing. C is symmetric, and the same seen from
// the other end, so that it serves A2M after M2A as well.

#include <cmath>

namespace smaservo {

/// Bounds of θ in wire files and devices.
struct LoopOddsRange {
  double min = 0.1, max = 100;
};
inline constexpr LoopOddsRange loop_odds_range;

/// The shares of a pool along a branch. The outer curve's share is counted from 1 to 0.
template <class S>
struct LoopOrder {
  S a;  ///< θ - 1
  S q;  ///< share that the other direction had converted at the turning point behind this branch

  /// Whether it(v) is anything but v: the branch is not an outer one, and θ is not 1.
  bool matters() const { return (a < S(0) || S(0) < a) && q < S(1); }

  /// C(v, q), which takes the place of the outer curve v; only its ratios are used.
  /// Cost: a square root, a division, 20 flops; nothing where it does not matter.
  S operator()(const S& v) const { return matters() ? joint(v) : v; }
  /// dC/dv
  S slope(const S& v) const { return matters() ? joint_slope(v) : S(1); }
  /// The v of a C between 0 and q.
  S inverse(const S& c) const { return matters() ? inverse_joint(c) : c; }

 private:
  // Not inline, since most wires need none of this.
  [[gnu::noinline]] S inverse_joint(const S& c) const {
    const S other = (a + S(1)) * (q - c);
    const S both = c + other;
    return S(0) < both ? c * (S(1) - q + both) / both : S(0);
  }
  [[gnu::noinline]] S joint(const S& v) const {
    return S(2) * (a + S(1)) * v * q / (S(1) + a * (v + q) + root(v));
  }
  [[gnu::noinline]] S joint_slope(const S& v) const {
    return S(0.5) - S(0.5) * (S(1) - S(2) * q + a * (v - q)) / root(v);
  }
  /// No term is negative where a is not: nothing cancels.
  S root(const S& v) const {
    using std::sqrt;
    const S square = S(1) + S(2) * a * (v + q - S(2) * v * q) + a * a * (v - q) * (v - q);
    return S(sqrt(square));
  }
};

}  // namespace smaservo
