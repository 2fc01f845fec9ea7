#pragma once
// A PID loop with heating power as its output: derivative on the filtered measurement, weights on
// the set-point, anti-windup by back-calculation, a separate gain when less heat is needed.
// Source: Astrom and Hagglund, 'Advanced PID Control', 2006, chapters 3.4 and 3.5.

#include "firmware/command.hpp"
#include "firmware/settings.hpp"

namespace smaservo {

template <class S>
struct Pid {
  struct State {
    S integral_W;
    S filtered;  ///< controlled variable less the weighted reference, low-pass filtered
    S base;      ///< reference at the start, from which the set-point's weight counts
  };

  /// The state of a loop that starts now, without a history.
  static State start(const LoopGains<S>& q, const S& reference, const S& measured) {
    return {S(0), measured - q.derivative_weight * reference, reference};
  }
  /// Continues with other gains. The integral is kept: it contains what the model does not know.
  static void resume(const LoopGains<S>& q, State& s, const S& reference, const S& measured) {
    s.filtered = measured - q.derivative_weight * reference;
  }

  /// The power in addition to the feed-forward. `direction` is +1 if heat raises the controlled
  /// variable, -1 if it lowers it. cooling_factor scales the proportional and integral part: on the
  /// other parts it would cause a step whenever the error changes its sign. The arguments must be
  /// finite: NaN would stay in the state. Cost: 30 flops, 2 divisions.
  static S step(const LoopGains<S>& q, const GainScale<S>& scale, const S& direction, State& s,
                const S& reference, const S& measured, const S& dt_s);

  /// Anti-windup: corrects the integral by the difference of the whole output before the limits
  /// (`wanted_W`) and after them (`given_W`). If the tracking time is far below 1/integral_1_s, the
  /// integral cancels the proportional part while a limit acts, and recovers slowly from that.
  static void limited(const LoopGains<S>& q, State& s, const S& wanted_W, const S& given_W,
                      const S& dt_s) {
    const S share = dt_s < q.tracking_s ? dt_s / q.tracking_s : S(1);
    s.integral_W = q.integral_1_s > S(0) ? s.integral_W + (given_W - wanted_W) * share : S(0);
  }

  static S outside(const S& error, const S& band) {
    return band < error ? error - band : error < -band ? error + band : S(0);
  }
};

template <class S>
S Pid<S>::step(const LoopGains<S>& q, const GainScale<S>& scale, const S& direction, State& s,
               const S& reference, const S& measured, const S& dt_s) {
  const S error = direction * outside(reference - measured, q.dead_band);
  const S K = direction * q.proportional;
  const S K_error = q.proportional * (error < S(0) ? q.cooling_factor : S(1)) * error;
  // y - c r, filtered
  const S change = measured - q.derivative_weight * reference - s.filtered;
  const S rises_1_s = change / (dt_s + q.derivative_filter_s);
  s.filtered += rises_1_s * dt_s;
  s.integral_W = q.integral_1_s > S(0)
                     ? s.integral_W + scale.integral * q.integral_1_s * K_error * dt_s
                     : S(0);
  // u = K (b r - y) + I + K T_d d(c r - y)/dt; the weight b acts on r - base only
  const S weighed = (S(1) - q.setpoint_weight) * (reference - s.base);
  return scale.proportional * (K_error - K * weighed) + s.integral_W -
         scale.derivative * K * q.derivative_s * rises_1_s;
}

}  // namespace smaservo
