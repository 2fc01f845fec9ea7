#pragma once
// One transformation process as a surface over temperature and stress.
// Source: paper 000, 'Stress dependence of the transformation parameters', figures 16 and 17.

#include <cstddef>
#include <iterator>

#include "model/kinetics.hpp"
#include "model/wire/three_phase/ihyp.hpp"

namespace smaservo {

/// Bounds that a surface must fulfil at every stress from 0 to the wire's limit. Wire files and a
/// device's settings are checked at `stresses` stresses, equally far apart.
struct SurfaceRange {
  double min_K = 150, max_K = 600;  ///< range of start and finish
  double min_span_K = 1;  ///< least distance from start to finish, in the direction of the process
  double min_curvature = 1e-3, max_curvature = 30;
  double min_turning = 0.05, max_turning = 0.95;
  double max_taper = 20;  ///< the same at every stress, from 0 on
  int stresses = 21;
};
inline constexpr SurfaceRange surface_range;

/// Coefficients by power of the stress in Pa. Valid within `surface_range`.
template <class S>
struct Surface {
  S start_K[3];    ///< T_s, a polynomial of second order
  S finish_K[3];   ///< T_f; above T_s for heating processes, below it for cooling ones
  S curvature[2];  ///< Γ, linear
  S turning[2];    ///< z_T, linear
  S taper = S(0);  ///< κ, the same at every stress; 0 in 000

  /// The shift of T_s when the stress changes.
  constexpr S start_shift_K(const S& from_Pa, const S& to_Pa) const {
    return (to_Pa - from_Pa) * (start_K[1] + (to_Pa + from_Pa) * start_K[2]);
  }
};

/// Combines two surfaces side by side; the functions below give each of them back.
template <class S>
Surface<Pair<S>> pair_surfaces(const Surface<S>& first, const Surface<S>& second) {
  Surface<Pair<S>> both;
  const auto pair = [](const auto& a, const auto& b, auto& to) {
    for (std::size_t i = 0; i < std::size(to); ++i) {
      to[i] = Pair<S>(a[i], b[i]);
    }
  };
  pair(first.start_K, second.start_K, both.start_K);
  pair(first.finish_K, second.finish_K, both.finish_K);
  pair(first.curvature, second.curvature, both.curvature);
  pair(first.turning, second.turning, both.turning);
  both.taper = Pair<S>(first.taper, second.taper);
  return both;
}

/// Applies `f` to every coefficient: converts to another scalar, or to one lane of a pair.
template <class To, class From, class F>
Surface<To> convert_surface(const Surface<From>& from, F f) {
  Surface<To> to;
  const auto each = [&](const auto& a, auto& b) {
    for (std::size_t i = 0; i < std::size(a); ++i) {
      b[i] = f(a[i]);
    }
  };
  each(from.start_K, to.start_K);
  each(from.finish_K, to.finish_K);
  each(from.curvature, to.curvature);
  each(from.turning, to.turning);
  to.taper = f(from.taper);
  return to;
}
template <class S>
Surface<S> first_surface(const Surface<Pair<S>>& both) {
  return convert_surface<S>(both, [](const Pair<S>& pair) { return pair.first(); });
}
template <class S>
Surface<S> second_surface(const Surface<Pair<S>>& both) {
  return convert_surface<S>(both, [](const Pair<S>& pair) { return pair.second(); });
}

/// The surface cut at one stress: the transformation curve over temperature.
template <class S>
struct Isobar {
  S start_K;
  S per_K;  ///< 1/(T_f - T_s), signed
  IhypShape<S> shape;

  /// Fraction that a complete run along the outer curve would have left at this temperature.
  S remaining(S temperature_K) const {
    return ihyp_fraction(shape, (temperature_K - start_K) * per_K).remaining;
  }
  /// Derivative of remaining() over temperature, from the remaining fraction there.
  S remaining_1_K(S remaining) const {
    return -(per_K / ihyp_slope(shape, Split<S>{S(1) - remaining, remaining}));
  }
};

template <class S>
constexpr Isobar<Pair<S>> pair_isobars(const Isobar<S>& first, const Isobar<S>& second) {
  return {Pair<S>(first.start_K, second.start_K),
          Pair<S>(first.per_K, second.per_K),
          {Pair<S>(first.shape.curvature, second.shape.curvature),
           Pair<S>(first.shape.turning, second.shape.turning),
           Pair<S>(first.shape.taper, second.shape.taper)}};
}

/// The first of two isobars that lie side by side.
template <class S>
constexpr Isobar<S> first_isobar(const Isobar<Pair<S>>& both) {
  return {both.start_K.first(),
          both.per_K.first(),
          {both.shape.curvature.first(), both.shape.turning.first(), both.shape.taper.first()}};
}

template <class S>
constexpr Isobar<S> isobar(const Surface<S>& surface, S stress_Pa) {
  const auto quadratic = [&](const S(&c)[3]) {
    return c[0] + stress_Pa * (c[1] + stress_Pa * c[2]);
  };
  const auto line = [&](const S(&c)[2]) { return c[0] + stress_Pa * c[1]; };
  const S start = quadratic(surface.start_K);
  return {start,
          S(1) / (quadratic(surface.finish_K) - start),
          {line(surface.curvature), line(surface.turning), surface.taper}};
}

}  // namespace smaservo
