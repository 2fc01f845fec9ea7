#pragma once
// The reference strain that the loop follows, from the wire's present strain to the set-point.

#include "firmware/settings.hpp"

namespace smaservo {

template <class S>
struct Trajectory {
  struct Result {
    S reference;
    bool waits;  ///< the reference waits, since the wire cannot cool any faster
  };

  /// Greatest strain by which the reference may lead a cooling wire: 2 % of a 4 % stroke. At this
  /// lead the reference waits and the heat is off: cooling is passive and cannot be made faster.
  static constexpr S lead = S(8e-4);

  /// Moves the reference on from `before`, no faster than the rates allow. Only if it leads the
  /// wire by more than `lead`, because the estimate has jumped, it is set back at once to the lead
  /// `lead`.
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
