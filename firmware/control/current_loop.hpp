#pragma once
// Computes the command to the output stage from a wanted current: feed-forward, and a PI loop on
// the measured current that corrects the stage's errors of gain and offset.

#include "firmware/settings.hpp"
#include "model/scalar/order.hpp"
#include "model/scalar/scalar.hpp"

namespace smaservo {

template <class S>
struct CurrentLoop {
  struct State {
    S asked_A;  ///< wanted current of the last step
    S trim_A;   ///< integral part of the correction
  };
  struct Result {
    S current_A;  ///< for an output stage that takes a current
    S voltage_V;  ///< V = I R, for an output stage that takes a voltage
  };

  /// Greatest correction by the loop, as a share of the wanted current.
  static constexpr S max = S(0.1);

  /// `measured_A` is the response to the current of the last step; it may be NaN. Cost: 12 flops.
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
