#pragma once
// The strain that the loop follows: from where the wire is to the set-point.

#include "firmware/settings.hpp"

namespace smaservo {

template <class S>
struct Trajectory {
  struct Result {
    S reference;
    bool waits;  ///< for the wire: it can not cool any faster
  };

  /// How far ahead of the wire a reference may run while it cools: 2 % of 4 % stroke. Enough to
  /// keep the heat off, so the wire cools as fast as it can, and no more: cooling is passive.
  static constexpr S lead = S(8e-4);

  static Result step(const TrajectorySettings<S>& q, const S& before, const S& setpoint,
                     const S& strain, const S& dt_s) {
    const S heated = before - q.heating_rate_1_s * dt_s;
    const S cooled = before + q.cooling_rate_1_s * dt_s;
    if (setpoint < before) {
      return {setpoint < heated ? heated : setpoint, false};
    }
    const S asked = cooled < setpoint ? cooled : setpoint;
    const S most = strain + lead;
    if (most < asked) {
      return {most < before ? before : most, true};
    }
    return {asked, false};
  }
};

}  // namespace smaservo
