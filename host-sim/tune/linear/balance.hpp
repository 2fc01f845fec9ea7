#pragma once

#include <cmath>

#include "host-sim/tune/linear/operating_points.hpp"

namespace smaservo::tune {

/// The stress at which wire and spring balance, searched from the previous one. `shorter` gives the
/// strain by which the wire is shorter than at rest at a stress. More stress makes it longer, so
/// there is one balance. It is found to 10 Pa in about six calls; a constant load needs none.
template <class F>
double balanced_stress_Pa(const TunedLoad& load, double from_Pa, const F& shorter) {
  if (!load.is_spring()) {
    return load.low_Pa;
  }
  const auto excess = [&](double stress_Pa) {
    return stress_Pa - load.stress_Pa(shorter(stress_Pa));
  };
  double a = from_Pa;
  double at_a = excess(a);
  double b = a - at_a;
  double at_b = excess(b);
  // Illinois method: the value at the end that is kept is halved.
  for (int i = 0; i < 40 && 10 < std::abs(b - a) && 10 < std::abs(at_b); ++i) {
    const double c = b - at_b * (b - a) / (at_b - at_a);
    const double at_c = excess(c);
    if ((at_c < 0) == (at_b < 0)) {
      at_a *= 0.5;
    } else {
      a = b;
      at_a = at_b;
    }
    b = c;
    at_b = at_c;
  }
  return b;
}

}  // namespace smaservo::tune
