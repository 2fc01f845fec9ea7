#pragma once
// The scalar type for the derivatives of the fit.

#include <ceres/jet.h>

namespace smaservo::identify {

/// Number of parameters whose derivatives are computed at once.
inline constexpr int jet_width = 16;
using Jet = ceres::Jet<double, jet_width>;

}  // namespace smaservo::identify

namespace ceres {

/// Ceres multiplies by the reciprocal, which rounds twice. A path through the hysteresis reverses
/// where a comparison decides so, and must be the same with and without derivatives, to the bit.
/// Only the derivatives may be rounded differently.
inline smaservo::identify::Jet operator/(const smaservo::identify::Jet& f,
                                         const smaservo::identify::Jet& g) {
  const double quotient = f.a / g.a;
  const double reciprocal = 1 / g.a;
  return {quotient, (f.v - quotient * g.v) * reciprocal};
}

}  // namespace ceres
