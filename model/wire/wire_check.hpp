#pragma once
// What must hold between the numbers of a wire. That each is within its own range is not checked
// here: the rows of wire_parameters.hpp have the ranges.

#include <string_view>

#include "model/wire/wire.hpp"

namespace smaservo {

/// A rule of a wire that does not hold.
struct WireProblem {
  enum class Rule : unsigned char {
    range_K,      ///< start and finish are within surface_range
    span_K,       ///< the finish is far enough above the start, on cooling below it
    curvature,    ///< is within surface_range
    turning,      ///< is within surface_range
    latent_heat,  ///< of R-phase, not above that of martensite: a closed cycle would gain heat
  };
  Rule rule;
  std::string_view process;  ///< such as "wire.m2a"; "" for latent_heat
  bool heating;
  double value;  ///< that breaks the rule
  double stress_Pa;
};

/// Calls found(problem) for each problem of a surface, at stresses from 0 to the wire's limit.
template <class Found>
void check_surface(const Surface<double>& surface, std::string_view process, bool heating,
                   double highest_stress_Pa, Found found) {
  using enum WireProblem::Rule;
  constexpr const SurfaceRange& range = surface_range;
  for (int i = 0; i < range.stresses; ++i) {
    const double stress_Pa = highest_stress_Pa * i / (range.stresses - 1);
    const Isobar<double> at = isobar(surface, stress_Pa);
    const double span_K = (heating ? 1 : -1) / at.per_K;
    const auto check = [&](WireProblem::Rule rule, double x, double min, double max) {
      if (!(min <= x && x <= max)) {
        found(WireProblem{rule, process, heating, x, stress_Pa});
      }
    };
    check(range_K, at.start_K, range.min_K, range.max_K);
    check(range_K, at.start_K + 1 / at.per_K, range.min_K, range.max_K);
    if (!(span_K >= range.min_span_K)) {
      found(WireProblem{WireProblem::Rule::span_K, process, heating, span_K, stress_Pa});
    }
    check(curvature, at.shape.curvature, range.min_curvature, range.max_curvature);
    check(turning, at.shape.turning, range.min_turning, range.max_turning);
  }
}

/// Calls found(problem) for each problem of the wire.
template <class Found>
void check_wire_rules(const Wire<double>& wire, Found found) {
  const ThreePhaseParams<double>& k = wire.kinetics;
  const double stress_Pa = wire.limits.stress_Pa;
  check_surface(k.m2a, "wire.m2a", true, stress_Pa, found);
  check_surface(first_surface(k.a2m_a2r), "wire.a2m", false, stress_Pa, found);
  check_surface(second_surface(k.a2m_a2r), "wire.a2r", false, stress_Pa, found);
  if (k.separate_r2a) {
    check_surface(k.r2a, "wire.r2a", true, stress_Pa, found);
  }
  if (k.separate_r2m) {
    check_surface(k.r2m, "wire.r2m", false, stress_Pa, found);
  }
  if (wire.heat.latent_r2a_J_kg > wire.heat.latent_m2a_J_kg) {
    found(WireProblem{WireProblem::Rule::latent_heat, "", true, wire.heat.latent_r2a_J_kg, 0});
  }
}

}  // namespace smaservo
