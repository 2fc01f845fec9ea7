#pragma once
// The ihyp transformation function: the converted fraction of one phase transformation over
// temperature.
// Source: paper 000, 'Transformation function' (two hyperbolas and a line). Its formula is
// reconstructed from the properties stated there and simplified; model/README.md has the steps.

#include <cmath>
#include <limits>

#include "model/scalar/pair.hpp"

namespace smaservo {

/// Shape of one transformation. Every curvature > 0 and 0 < turning < 1 is valid.
template <class S>
struct IhypShape {
  S curvature;  ///< Γ, bends both ends of the straight line; real wires need 2..6
  S turning;    ///< z_T, converted fraction at the turning point (inflection), where the curve is
                ///< steepest
  /// κ, how fast both ends approach 0 and 1: in 000 like 1/tau, which is κ = 0; else like 1/tau⁴
  /// where κ (tau - z_T)² is great. Ours: model/README.md.
  S taper = S(0);
};

/// A converted fraction x and its complement 1 - x, each to its own relative accuracy.
template <class S>
struct Split {
  S converted;  ///< x, in (0, 1)
  S remaining;  ///< 1 - x, in (0, 1)
};

/// Whether the curve is not paper 000's.
template <class S>
constexpr bool is_tapered(const IhypShape<S>& shape) {
  return any(S(0) < shape.taper);
}

/// One half of the taper: e = d sqrt(1 + κ d²). The other half does the same to e. Distances are
/// from the turning point, and normalised.
template <class S>
S taper_half(const S& taper, const S& d) {
  using std::sqrt;
  const S stretch = sqrt(S(1) + taper * d * d);
  return d * stretch;
}
/// The inverse of a half: d² = 2 e²/(1 + sqrt(1 + 4 κ e²)).
template <class S>
S without_taper_half(const S& taper, const S& e) {
  using std::sqrt;
  const S root = sqrt(S(1) + S(4) * taper * e * e);
  const S shrink = sqrt(S(2) / (S(1) + root));
  return e * shrink;
}
/// The inverse of on_papers_curve().
template <class S>
[[gnu::noinline]] S off_papers_curve(const IhypShape<S>& shape, const S& tau) {
  const S e = without_taper_half(shape.taper, tau - shape.turning);
  return select(S(0) < shape.taper, shape.turning + without_taper_half(shape.taper, e), tau);
}
/// The place on paper 000's curve that has the fraction of a place on the tapered one.
template <class S>
S on_papers_curve(const IhypShape<S>& shape, const S& tau) {
  const S e = taper_half(shape.taper, tau - shape.turning);
  return select(S(0) < shape.taper, shape.turning + taper_half(shape.taper, e), tau);
}

/// What the taper makes of the slope dtau/dx at a fraction:
///   sqrt((1 + κ d²)(1 + κ e²))/((1 + 2 κ d²)(1 + 2 κ e²))
template <class S>
[[gnu::noinline]] S taper_slope(const IhypShape<S>& shape, const Split<S>& fraction) {
  using std::sqrt;
  const S x = fraction.converted;
  const S y = fraction.remaining;
  const S u = select(x < y, x - shape.turning, (S(1) - shape.turning) - y);
  const S e = without_taper_half(shape.taper, u + shape.curvature * u * u * u / (x * y));
  const S d = without_taper_half(shape.taper, e);
  const S kd = shape.taper * d * d;
  const S ke = shape.taper * e * e;
  const S root = sqrt((S(1) + kd) * (S(1) + ke));
  return select(S(0) < shape.taper, root / ((S(1) + kd + kd) * (S(1) + ke + ke)), S(1));
}

/// Normalised temperature tau = (T - T_s) / (T_f - T_s) at which the fraction x is converted.
/// Strictly rising in x, from -infinity at x = 0 to +infinity at x = 1. Cost: 9 flops, 1 division.
template <class S>
constexpr S ihyp_temperature(const IhypShape<S>& shape, const Split<S>& fraction) {
  const S x = fraction.converted;
  const S y = fraction.remaining;
  // The distance to the turning point, x - z_T, from the smaller of the two fractions.
  const S u = select(x < y, x - shape.turning, (S(1) - shape.turning) - y);
  // tau = x + Γ (x - z_T)³ / (x (1 - x))
  const S tau = x + shape.curvature * u * u * u / (x * y);
  return is_tapered(shape) ? off_papers_curve(shape, tau) : tau;
}

/// dtau/dx, at least 1 everywhere and 1 at the turning point. Cost: 10 flops, 2 divisions.
template <class S>
constexpr S ihyp_slope(const IhypShape<S>& shape, const Split<S>& fraction) {
  const S a = shape.turning;
  const S b = S(1) - a;
  const S p = a / fraction.converted;
  const S q = b / fraction.remaining;
  // tau' = 1 + Γ (z_T³/x² + (1 - z_T)³/(1 - x)² - 1)
  const S papers = S(1) + shape.curvature * (a * p * p + b * q * q - S(1));
  if (is_tapered(shape)) [[unlikely]] {
    return papers * taper_slope(IhypShape<S>{shape}, Split<S>{fraction});
  }
  return papers;  // NOLINT(performance-no-automatic-move): it is a number
}

template <class S>
[[gnu::noinline]] Split<S> tapered_fraction(const IhypShape<S>& shape, const S& tau);

/// The converted fraction at the normalised temperature tau: the inverse of ihyp_temperature(),
/// for |tau| <= 1e4. Explicit: a first guess and a fixed number of refinements, no iteration to a
/// tolerance. Worst error of the smaller of x and 1 - x for curvature 1e-3..30 and turning
/// 0.05..0.95, relative / absolute: double 5.4e-14 / 9.1e-15, float 1.1e-6 / 1.7e-7 (where the
/// greater one may round to 1).
/// Cost: 51 (float) or 68 (double) flops, 1 square root, 5 (float) or 6 divisions.
template <class S>
Split<S> ihyp_fraction(const IhypShape<S>& shape, S tau) {
  using std::sqrt;
  if (is_tapered(shape)) [[unlikely]] {
    return tapered_fraction(IhypShape<S>{shape}, tau);
  }
  const S one = S(1);
  // Both ends of the curve are the same equation when seen from the nearer end. Let y be the
  // fraction left towards that end, b its value at the turning point, a = 1 - b, e its value on
  // the straight line and d = b - e >= 0 the distance from the turning point. With v = b/y - 1,
  //   Γ b² v³/(v + a) + e v = d,    v >= 0, exactly one root.
  const auto lower = tau < shape.turning;
  const S e = select(lower, tau, one - tau);
  const S b = select(lower, shape.turning, one - shape.turning);
  const S a = select(lower, one - shape.turning, shape.turning);
  const S d = b - e;
  const S A = shape.curvature * b * b;

  // First guess, good to 8 %: v/(v + a) is replaced by 1 - a w/v with the estimate w = d/(d + b),
  // which leaves the quadratic A v² + E v = d.
  const S E = e - a * A * (d / (d + b));
  const S s = sqrt(E * E + S(4) * A * d);
  const auto beyond = E < S(0);
  S v = select(beyond, s - E, d + d) / select(beyond, A + A, s + E);

  // Householder steps on the cubic p(v) = A v³ + e v² + (a e - d) v - a d, of second order (Halley;
  // the error is cubed) for float, of third order (to the fourth power) for double.
  const S p1 = a * e - d;
  const S p0 = a * d;
  for (int i = 0; i < 2; ++i) {
    const S vv = v * v;
    const S Av = A * v;
    const S value = (Av + e) * vv + (p1 * v - p0);
    const S slope = S(3) * A * vv + ((e + e) * v + p1);
    const S half_bend = S(3) * Av + e;
    const S slope2 = slope * slope;
    const S bent = value * half_bend;
    if constexpr (std::numeric_limits<S>::digits <= 24) {
      v -= value * slope / (slope2 - bent);
    } else {
      v -= value * (slope2 - bent) / (slope * (slope2 - (bent + bent)) + value * value * A);
    }
  }

  const S scale = one / (one + v);
  const S near = b * scale;
  const S far = (a + v) * scale;
  return {select(lower, near, far), select(lower, far, near)};
}

/// The fraction on paper 000's curve beyond |tau| = 1e4, where less than 0.3 % is left. With y the
/// smaller fraction, b its value at the turning point and e its value on the straight line,
///   y = Γ b³/(Γ b² (3 - b) - e)
/// is good to 2e-5, and a Newton step on 1/y makes that 1e-9.
template <class S>
Split<S> ihyp_end(const IhypShape<S>& shape, const S& tau) {
  const auto lower = tau < shape.turning;
  const S e = select(lower, tau, S(1) - tau);
  const S b = select(lower, shape.turning, S(1) - shape.turning);
  const S bb = shape.curvature * b * b;
  const S y = bb * b / (bb * (S(3) - b) - e);
  const S u = y - b;
  const S error = y + shape.curvature * u * u * u / (y * (S(1) - y)) - e;
  const S a = S(1) - b;
  const S q = a / (S(1) - y);
  // y² tau'(y)
  const S slope = y * y * (S(1) + shape.curvature * (a * q * q - S(1))) + bb * b;
  const S near = y * slope / (slope + y * error);
  return {select(lower, near, S(1) - near), select(lower, S(1) - near, near)};
}

/// ihyp_fraction() of a curve whose ends are not paper 000's.
template <class S>
Split<S> tapered_fraction(const IhypShape<S>& shape, const S& tau) {
  const IhypShape<S> paper{shape.curvature, shape.turning};
  const S t = on_papers_curve(shape, tau);
  const S far = S(10000);
  Split<S> x = ihyp_fraction(paper, select(t < -far, -far, select(far < t, far, t)));
  if (!any(t < -far) && !any(far < t)) {
    return x;
  }
  const Split<S> end = ihyp_end(paper, t);
  const auto is_end = far * far < t * t;
  return {select(is_end, end.converted, x.converted), select(is_end, end.remaining, x.remaining)};
}

}  // namespace smaservo
