#pragma once
// A PID loop with heating power as its output: derivative on the filtered measurement, weights on
// the set-point, anti-windup by back-calculation, gains of its own where less heat is asked for.
// Source: Astrom and Hagglund, 'Advanced PID Control', 2006, chapters 3.4 and 3.5.

#include "firmware/command.hpp"
#include "firmware/settings.hpp"

namespace smaservo {

template <class S>
struct Pid {
  struct State {
    S integral_W;
    S filtered;   ///< of the controlled variable
    S reference;  ///< of the last step
  };

  /// From here on, without a derivative from before. What the integral held is the transfer's.
  static State start(const S& measured, const S& reference) { return {S(0), measured, reference}; }

  /// Power beyond the feed-forward. `direction` is +1 where heat raises the controlled variable, -1
  /// where it lowers it. Cost: 30 flops, 1 division.
  static S step(const LoopGains<S>& q, const GainScale<S>& scale, const S& direction, State& s,
                const S& reference, const S& measured, const S& dt_s);

  /// Tells the integral what became of the output that step() was part of: wanted before the
  /// limits, given after them.
  static void limited(const LoopGains<S>& q, State& s, const S& wanted_W, const S& given_W,
                      const S& dt_s) {
    const S share = dt_s < q.tracking_s ? dt_s / q.tracking_s : S(1);
    const S back_W = (given_W - wanted_W) * share;
    s.integral_W = q.integral_1_s > S(0) ? s.integral_W + back_W : S(0);
  }

  static S outside(const S& error, const S& band) {
    return band < error ? error - band : error < S(0) - band ? error + band : S(0);
  }
};

template <class S>
S Pid<S>::step(const LoopGains<S>& q, const GainScale<S>& scale, const S& direction, State& s,
               const S& reference, const S& measured, const S& dt_s) {
  const S error = direction * outside(reference - measured, q.dead_band);
  const S before = s.filtered;
  s.filtered = before + (measured - before) * (dt_s / (dt_s + q.derivative_filter_s));
  const S rises_1_s = (s.filtered - before) / dt_s;
  const S wanted_1_s = (reference - s.reference) / dt_s;
  s.reference = reference;
  const S K = q.proportional * (error < S(0) ? q.cooling_factor : S(1));
  s.integral_W = s.integral_W + scale.integral * K * q.integral_1_s * error * dt_s;
  // u = K (b r - y) + I + K T_d d(c r - y)/dt
  const S proportional_W =
      scale.proportional * K *
      (error - direction * (S(1) - q.setpoint_weight) * (reference - measured));
  const S derivative_W = scale.derivative * K * q.derivative_s * direction *
                         (q.derivative_weight * wanted_1_s - rises_1_s);
  return proportional_W + s.integral_W + derivative_W;
}

}  // namespace smaservo
