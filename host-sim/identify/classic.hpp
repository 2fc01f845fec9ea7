#pragma once
// The transformation functions that most models use. The errors of a fit of the project's model are
// compared with theirs.

#include <algorithm>
#include <cmath>
#include <string_view>
#include <type_traits>
#include <vector>

#include "host-sim/identify/runs/run.hpp"

namespace smaservo::identify {

/// A curve from 1 to 0 through the T-z-plane, made of four support points: (0, 1), two inner ones
/// and (1, 0) (000, 'Transformation function', after Enemark and Santos 2016).
template <class S>
struct BezierShape {
  /// Abscissae of the inner support points, 0.02..0.98, so that the slope is finite everywhere.
  S t_1, t_2;
  S z_1, z_2;
};

namespace detail {

/// The positive root of (1 - x) w³ + (3 t_2 - 3 x) w² + (3 t_1 - 3 x) w - x = 0 for x <= 1/2.
inline double bezier_ratio(double t_1, double t_2, double x) {
  // w = y - b/3; y³ + 3 p y + 2 q = 0
  const double b = 3 * (t_2 - x) / (1 - x);
  const double c = 3 * (t_1 - x) / (1 - x);
  const double d = -x / (1 - x);
  const double p = (c - b * b / 3) / 3;
  const double q = (2 * b * b * b / 27 - b * c / 3 + d) / 2;
  const double D = q * q + p * p * p;
  if (D >= 0) {
    const double largest = std::cbrt(std::abs(q) + std::sqrt(D));
    const double y = largest > 0 ? largest - p / largest : 0;
    return (q < 0 ? y : -y) - b / 3;
  }
  // All three roots are real; only the greatest is positive.
  const double r = std::sqrt(-p);
  const double cosine = std::clamp(-q / (r * r * r), -1.0, 1.0);
  return 2 * r * std::cos(std::acos(cosine) / 3) - b / 3;
}

}  // namespace detail

/// The ordinate z at t, which is 1 before the curve and 0 behind it. Each point is a function of a
/// parameter s in 0..1; 000 finds s by iteration. Here it follows from Cardano's formula: with the
/// ratio w = s/(1 - s), counted from the nearer end, the cubic has one positive root and a leading
/// coefficient that is never small. One Newton step removes rounding errors and yields the
/// derivatives for other scalars.
template <class S>
S bezier_fraction(const BezierShape<S>& shape, const S& t) {
  if (t <= S(0)) {
    return S(1);
  }
  if (t >= S(1)) {
    return S(0);
  }
  const auto plain = [](const S& x) {
    if constexpr (std::is_floating_point_v<S>) {
      return static_cast<double>(x);
    } else {
      return x.a;
    }
  };
  const bool near = t <= S(0.5);
  const double t_1 = plain(shape.t_1);
  const double t_2 = plain(shape.t_2);
  const double w = near ? detail::bezier_ratio(t_1, t_2, plain(t))
                        : detail::bezier_ratio(1 - t_2, 1 - t_1, 1 - plain(t));
  const S s_0 = S(near ? w / (1 + w) : 1 / (1 + w));
  // Bernstein polynomials
  const S u_0 = S(1) - s_0;
  const S at = S(3) * s_0 * u_0 * (u_0 * shape.t_1 + s_0 * shape.t_2) + s_0 * s_0 * s_0;
  const S slope = S(3) * (u_0 * u_0 * shape.t_1 + S(2) * u_0 * s_0 * (shape.t_2 - shape.t_1) +
                          s_0 * s_0 * (S(1) - shape.t_2));
  const S s = s_0 - (at - t) / slope;
  const S u = S(1) - s;
  return u * u * u + S(3) * s * u * (u * shape.z_1 + s * shape.z_2);
}

/// Fits a run's strain by eps_A + (eps_M - eps_A) xi(T). The martensite fraction xi has its own
/// centre and width on heating and on cooling; both share the plateau strains. The functions are
/// cosine (Liang and Rogers 1990), tanh and arctan. There is no unloading, no minor loop and no
/// R-phase. Bezier and ihyp curves also have a shape for each direction.
struct ClassicFit {
  std::string_view name;  ///< "cosine", "tanh", "arctan", "Bezier" or "ihyp"
  /// Statistics of the error, as shares of the stroke, which is the span of the strain.
  double rms, p95, max;
  std::vector<double> strain;  ///< the fitted strain of each row
  double martensite_strain, austenite_strain;
  double heating_K, heating_width_K;  ///< centre and width, see fraction() in classic.cpp
  double cooling_K, cooling_width_K;
};

/// Least squares over all rows, with equal weights; if there are more than 2000 rows, over every
/// n-th. Takes about 20 ms for 500 rows.
/// Empty if the fits would be meaningless: for runs that are not in a bath, have no strain, whose
/// stress leaves its median by more than an eighth (and 5 MPa) in more than a twentieth of the rows
/// to either side, or that are not one heating and one cooling through the whole transformation, of
/// which either may come first.
std::vector<ClassicFit> fit_classics(const Run& run);

/// Like fit_classics(), for the functions that adapt to a curve: a Bezier curve of four support
/// points, whose width extends from the first to the last of them, and ihyp, whose width extends
/// from start to finish. Takes about 0.1 s for 500 rows.
std::vector<ClassicFit> fit_adaptable(const Run& run);

}  // namespace smaservo::identify
