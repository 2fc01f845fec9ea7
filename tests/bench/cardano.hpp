#pragma once
// Two other inverses of the ihyp function, measured beside the model's own.

#include <cmath>
#include <numbers>

#include "model/wire/three_phase/ihyp.hpp"

namespace smaservo::benchmarks {

/// The greatest root of w³ + a w² + b w + c, by Viète's cosines where there are three real roots,
/// by the hyperbolic functions where there is one.
template <class S>
S max_cubic_root(S a, S b, S c) {
  // w = size * t keeps every power within the range of float.
  const S size = std::max(std::abs(a), std::max(std::sqrt(std::abs(b)), std::cbrt(std::abs(c))));
  const S a1 = a / size;
  const S b1 = b / (size * size);
  const S c1 = c / (size * size * size);
  // t = s - a1/3:  s³ + 3 p s + 2 q = 0
  const S third = a1 / S(3);
  const S p = b1 / S(3) - third * third;
  const S q = third * third * third - third * b1 / S(2) + c1 / S(2);
  const S r = std::copysign(std::sqrt(std::abs(p)), q);
  const S ratio = q / (r * r * r);
  S s;
  if (p < S(0) && ratio <= S(1)) {
    const S angle = std::acos(ratio) / S(3);
    s = q < S(0) ? S(-2) * r * std::cos(angle)
                 : S(2) * r * std::cos(std::numbers::pi_v<S> / S(3) - angle);
  } else if (p < S(0)) {
    s = S(-2) * r * std::cosh(std::acosh(ratio) / S(3));
  } else {
    s = S(-2) * r * std::sinh(std::asinh(ratio) / S(3));
  }
  return size * (s - third);
}

/// Cardano's formula on the cubic in w = x/(1 - x).
template <class S>
Split<S> cardano_fraction(const IhypShape<S>& shape, S tau) {
  // Below the turning point the mirrored curve, so that the wanted root is the greatest.
  const bool lower = tau < shape.turning;
  const S h = lower ? S(1) - tau : tau;
  const S z = lower ? S(1) - shape.turning : shape.turning;
  const S G = shape.curvature;
  // B w³ + (2B - A + C - h') w² + (B - 2A - h') w - A = 0,  h' = tau - K
  const S A = G * z * z * z;
  const S B = G * (S(1) - z) * (S(1) - z) * (S(1) - z);
  const S K = G * (z + z * z - (S(1) - z) * (S(1) - z));
  const S rest = h - K;
  const S w =
      max_cubic_root((S(2) * B - A + (S(1) - G) - rest) / B, (B - S(2) * A - rest) / B, -A / B);
  const S far = S(1) / (S(1) + w);
  const S near = w / (S(1) + w);
  return lower ? Split<S>{far, near} : Split<S>{near, far};
}

/// Newton's method on tau(x), as many steps as the worst case needs, from the hyperbola of the
/// nearer end alone: the start is on the convex side, so that every step approaches the root.
template <class S>
Split<S> newton_fraction(const IhypShape<S>& shape, S tau) {
  constexpr int steps = std::numeric_limits<S>::digits <= 24 ? 7 : 9;
  const bool lower = tau < shape.turning;
  const S h = lower ? S(1) - tau : tau;
  const S z = lower ? S(1) - shape.turning : shape.turning;
  const S b = S(1) - z;
  const S G = shape.curvature;
  // (G - 1) y² - β y + G b³ = 0,  y = 1 - x
  const S g = G * b * b * b;
  const S beta = h - S(1) + G * (b * b + b);
  const S square = beta * beta - S(4) * (G - S(1)) * g;
  const S root = std::sqrt(std::max(square, S(0)));
  S y = beta < S(0) ? (root - beta) / (S(2) * (S(1) - G)) : S(2) * g / (beta + root);
  y = std::min(y, b);
  for (int i = 0; i < steps; ++i) {
    const S x = S(1) - y;
    const S u = b - y;
    const S excess = x + G * u * u * u / (x * y) - h;
    const S slope = S(1) + G * (z * z * z / (x * x) + b * b * b / (y * y) - S(1));
    y += excess / slope;
  }
  return lower ? Split<S>{y, S(1) - y} : Split<S>{S(1) - y, y};
}

}  // namespace smaservo::benchmarks
