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

  /// How far ahead of the wire a reference may run while it cools: 2 % of 4 % stroke. Where it
  /// would be further, it waits and the heat is off: cooling is passive, and no wire can do more.
  static constexpr S lead = S(8e-4);

  /// Moves on from `before` by no more than either rate allows. Only where the wire turns out to be
  /// more than the lead behind, because its estimate has jumped, does the reference come back to it
  /// at once.
  static Result step(const TrajectorySettings<S>& q, const S& before, const S& setpoint,
                     const S& strain, const S& dt_s) {
    const S max = strain + lead;
    const S from = max < before ? max : before;
    if (setpoint < from) {
      const S heated = from - q.heating_rate_1_s * dt_s;
      return {setpoint < heated ? heated : setpoint, false};
    }
    const S cooled = from + q.cooling_rate_1_s * dt_s;
    const S asked = cooled < setpoint ? cooled : setpoint;
    return max < asked ? Result{max, true} : Result{asked, false};
  }
};

}  // namespace smaservo
