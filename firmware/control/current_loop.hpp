#pragma once
// From a wanted current to what the output stage is told: feed-forward, and a PI loop on the
// measured current that corrects the stage's errors of gain and offset.

#include "firmware/settings.hpp"
#include "model/scalar/order.hpp"
#include "model/scalar/scalar.hpp"

namespace smaservo {

template <class S>
struct CurrentLoop {
  struct State {
    S asked_A;  ///< in the last step
    S trim_A;   ///< integral part
  };
  struct Result {
    S current_A;  ///< for a stage that takes a current
    S voltage_V;  ///< V = I R, for one that takes a voltage
  };

  /// Greatest correction by the loop, as a share of the wanted current.
  static constexpr S max = S(0.1);

  /// `measured_A` is the answer to the last step's current; it may be NaN. Cost: 12 flops.
  static Result step(const DriveSettings<S>& q, State& s, const S& asked_A, const S& measured_A,
                     const S& ohm, const S& dt_s) {
    const S error = isfinite(measured_A) ? s.asked_A - measured_A : S(0);
    const S bound = max * asked_A;
    s.trim_A = clamp(s.trim_A + q.integral_1_s * error * dt_s, -bound, bound);
    s.asked_A = asked_A;
    const S current_A = asked_A + clamp(s.trim_A + q.proportional * error, -bound, bound);
    return {current_A, current_A * ohm};
  }
};

}  // namespace smaservo
