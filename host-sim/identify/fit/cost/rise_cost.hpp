#pragma once
// The Clausius-Clapeyron law as residuals: penalties for transition temperatures that fall with
// stress.

#include <cstddef>

#include "host-sim/identify/fit/cost/run_cost.hpp"
#include "host-sim/identify/fit/slopes.hpp"

namespace smaservo::identify {

/// One residual for each slope of each process: 0 if the temperature rises with stress or stays,
/// and steep if it falls: a fall of 0.002 K/MPa costs as much as an error of one standard
/// deviation. If it were twenty times as steep, the solver would stop at the kink, far from the
/// minimum.
class RiseCost {
 public:
  explicit RiseCost(const FitProblem& problem) : problem_(problem) {}

  /// It depends on no path.
  static Path path(const double* /*u*/) { return {}; }

  template <class T>
  void operator()(const T* u, const Path& /*path*/, T* residual) const {
    constexpr double fall_sd_K_Pa = 2e-9;
    const auto next = [&](const FitParameter& parameter) { return parameter.value(*u++); };
    const Wire<T> wire = vary_wire<T>(problem_.from, problem_.variant, next);
    for (const auto& [process, surface] : surfaces(wire)) {
      for (const T& slope_K_Pa : slopes_K_Pa(surface, problem_.from.limits.stress_Pa)) {
        *residual++ = slope_K_Pa < T(0) ? T(slope_K_Pa / T(fall_sd_K_Pa)) : T(0);
      }
    }
  }

  std::size_t residuals() const {
    const FitVariant& v = problem_.variant;
    return std::size_t{4} * (3U + (v.separate_r2a ? 1U : 0U) + (v.separate_r2m ? 1U : 0U));
  }

 private:
  const FitProblem& problem_;
};

}  // namespace smaservo::identify
