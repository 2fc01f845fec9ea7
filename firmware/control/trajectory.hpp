#pragma once
// The strain that the loop follows: from where the wire is to the set-point.

#include "firmware/settings.hpp"

namespace smaservo {

template <class S>
struct Trajectory {
  struct Result {
    S reference;
    bool waits;  ///< for the wire: it cannot cool any faster
  };

  /// How far, in strain, the reference may run ahead of a wire that cools: 2 % of a stroke of 4 %.
  /// There it waits and the heat is off: cooling is passive and cannot be made faster.
  static constexpr S lead = S(8e-4);

  /// Moves the reference on from `before`, no faster than the rates allow. Only if the wire is more
  /// than `lead` behind, because its estimate has jumped, the reference comes back at once, to
  /// `lead` ahead of the wire.
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
