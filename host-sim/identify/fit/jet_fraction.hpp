#pragma once
// ihyp_fraction() for the scalar of the fit. The model's templates find these functions in place of
// their own one, so a source that uses the model with Jet includes this file and not jet.hpp.

#include <cmath>

#include "host-sim/identify/fit/jet.hpp"
#include "model/scalar/pair.hpp"
#include "model/wire/three_phase/ihyp.hpp"

namespace smaservo::identify {

/// The fraction x with its derivatives. The implicit function theorem gives them from the equation
/// that ihyp_temperature() has for x, in place of derivatives of each step that solves it:
///   tau' dx = dt - u³/(x (1 - x)) dΓ + 3 Γ u²/(x (1 - x)) dz_T,    u = x - z_T
/// with the place t on paper 000's curve, on_papers_curve(), and the slope tau' of that curve.
inline Split<Jet> with_derivatives(const IhypShape<Jet>& shape, const Jet& tau,
                                   const Split<double>& x) {
  const IhypShape<double> paper{shape.curvature.a, shape.turning.a};
  // dt by tau and by κ; by z_T it is 1 - t_tau.
  double t_tau = 1;
  double t_taper = 0;
  if (const double taper = shape.taper.a; taper > 0) {
    // Each half of the taper: e = d sqrt(1 + κ d²).
    double d = tau.a - paper.turning;
    for (int half = 0; half < 2; ++half) {
      const double stretch = std::sqrt(1 + taper * d * d);
      const double e_d = (1 + 2 * taper * d * d) / stretch;
      t_taper = e_d * t_taper + d * d * d / (2 * stretch);
      t_tau *= e_d;
      d *= stretch;
    }
  }
  const double u =
      x.converted < x.remaining ? x.converted - paper.turning : (1 - paper.turning) - x.remaining;
  const double bend = u * u / (x.converted * x.remaining);
  const double per_slope = 1 / ihyp_slope(paper, x);
  const double x_tau = per_slope * t_tau;
  const double x_curvature = -per_slope * bend * u;
  const double x_turning = per_slope * (1 - t_tau + 3 * paper.curvature * bend);
  const double x_taper = per_slope * t_taper;
  Split<Jet> result{Jet(x.converted), Jet(x.remaining)};
  for (int i = 0; i < Jet::size; ++i) {
    result.converted.v[i] = x_tau * tau.v[i] + x_curvature * shape.curvature.v[i] +
                            x_turning * shape.turning.v[i] + x_taper * shape.taper.v[i];
    result.remaining.v[i] = -result.converted.v[i];
  }
  return result;
}

inline Split<Jet> ihyp_fraction(const IhypShape<Jet>& shape, const Jet& tau) {
  const IhypShape<double> values{shape.curvature.a, shape.turning.a, shape.taper.a};
  return with_derivatives(shape, tau, smaservo::ihyp_fraction(values, tau.a));
}
inline Split<Pair<Jet>> ihyp_fraction(const IhypShape<Pair<Jet>>& both, const Pair<Jet>& tau) {
  const auto values = [](const Pair<Jet>& pair) {
    return Pair<double>(pair.first().a, pair.second().a);
  };
  const Split<Pair<double>> x = smaservo::ihyp_fraction(
      IhypShape<Pair<double>>{values(both.curvature), values(both.turning), values(both.taper)},
      values(tau));
  const Split<Jet> first =
      with_derivatives({both.curvature.first(), both.turning.first(), both.taper.first()},
                       tau.first(), {x.converted.first(), x.remaining.first()});
  const Split<Jet> second =
      with_derivatives({both.curvature.second(), both.turning.second(), both.taper.second()},
                       tau.second(), {x.converted.second(), x.remaining.second()});
  return {{first.converted, second.converted}, {first.remaining, second.remaining}};
}

}  // namespace smaservo::identify
