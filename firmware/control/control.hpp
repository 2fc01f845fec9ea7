#pragma once
// Computes the current of the next step from an estimate and a set-point. Every mode yields a
// heating power; limits, the transfer between modes and the current loop are the same for all.

#include <cmath>

#include "firmware/command.hpp"
#include "firmware/control/current_loop.hpp"
#include "firmware/control/feed_forward.hpp"
#include "firmware/control/pid.hpp"
#include "firmware/control/profile.hpp"
#include "firmware/control/soft_limits.hpp"
#include "firmware/control/trajectory.hpp"
#include "firmware/prepared.hpp"
#include "model/scalar/scalar.hpp"

namespace smaservo {

/// The request to the controller.
template <class S>
struct Demand {
  Mode mode;
  S setpoint;
  GainScale<S> scale;
};

template <class S>
struct Controller {
  struct State {
    Mode mode;
    bool entered;  ///< the mode has just been entered
    bool rebase;   ///< mode or settings are new: the output must not jump
    bool moving;   ///< the strain has to move towards the reference, until it is reached
    typename Pid<S>::State pid;
    typename CurrentLoop<S>::State current_loop;
    S reference;    ///< reference that the trajectory has reached
    S power_W;      ///< power given in the last step
    S transfer_W;   ///< jump of the power that the last change would have caused; fades out
    S duty;         ///< averaged square of the current as a share of the current limit
    S sustained_W;  ///< power averaged over the wire's thermal time constant
    bool streams;   ///< the set-point moves slowly enough to be followed
    S moves_1_s;    ///< filtered rate of a set-point that streams
    S elapsed_s;    ///< time in the present mode
  };

  struct Result {
    S drive_current_A, drive_voltage_V;
    S setpoint;   ///< set-point clamped to the limits
    S reference;  ///< reference of the trajectory, in the set-point's unit
    S wanted_power_W;
    std::uint32_t limit_reasons;
    bool invalid;  ///< the wanted power was not a number; the least power is given
  };

  /// A step without current. The loop starts anew afterwards.
  static void rest(const Prepared<S>& p, State& s, const S& dt_s);
  /// Like rest(), but assumes that the wire may have had this current all the time.
  [[gnu::noinline]] static void persist(const Prepared<S>& p, State& s, const S& current_A,
                                        const S& power_W, const S& dt_s);

  /// To be called when new settings take effect from the next step on.
  static void adopt(State& s) { s.rebase = true; }

  /// Gives no current if the estimate is not a number. A set-point that is not a number gives the
  /// least power, and the mode starts anew after it. Cost: 550 instructions on average over steps
  /// of the strain.
  static Result step(const Prepared<S>& p, State& s, const Demand<S>& demand,
                     const ControlInputs<S>& known, const S& dt_s);

 private:
  struct Loop {
    const LoopGains<S>& gains;
    S direction;  ///< +1 if heat raises the variable, -1 if it lowers it
    S measured;
    S forward_W;
  };
  struct PowerParts {
    S forward_W;   ///< feed-forward from the set-point or the model
    S feedback_W;  ///< output of the loop
  };

  static void enter(State& s, const Mode& mode, const S& strain);
  static S limited_setpoint(const Prepared<S>& p, const Demand<S>& demand, LimitReasons& reasons);
  static PowerParts wanted(const Prepared<S>& p, State& s, const Demand<S>& demand,
                           const ControlInputs<S>& known, const S& ohm, const S& loss_W,
                           LimitReasons& reasons, const S& dt_s);
  static void start_loop(const LoopGains<S>& gains, State& s, const S& reference,
                         const S& measured);
  static PowerParts loop(const Loop& loop, State& s, const Demand<S>& demand, const S& dt_s);
  static PowerParts strain_loop(const Prepared<S>& p, State& s, const Demand<S>& demand,
                                const ControlInputs<S>& known, const S& loss_W,
                                LimitReasons& reasons, const S& dt_s);
  static S limited_power_W(const Prepared<S>& p, State& s, const Mode& mode,
                           const PowerRange<S>& range, const PowerParts& wanted,
                           LimitReasons& reasons, const S& dt_s);
  static S averaged(const S& average, const S& now, const S& dt_s, const S& over_s) {
    return average + (now - average) * (dt_s / (dt_s + over_s));
  }
  /// Thermal time constant of the wire in air.
  static S time_constant_s(const Prepared<S>& p) {
    const auto& body = p.observer.model.body;
    return body.capacity_J_K / body.loss_W_K;
  }
  static S profile_W(const Prepared<S>& p, const State& s, const ControlInputs<S>& known);
  static const LoopGains<S>& gains(const Settings<S>& q, Mode mode);
  static S clamp(const S& x, const S& low, const S& high, LimitReason why, LimitReasons& reasons);
};

template <class S>
void Controller<S>::rest(const Prepared<S>& p, State& s, const S& dt_s) {
  const S duty = averaged(s.duty, S(0), dt_s, p.settings.limits.duty_window_s);
  const S sustained_W = averaged(s.sustained_W, S(0), dt_s, time_constant_s(p));
  s = State{};
  s.duty = duty;
  s.sustained_W = sustained_W;
}

template <class S>
void Controller<S>::persist(const Prepared<S>& p, State& s, const S& current_A, const S& power_W,
                            const S& dt_s) {
  const SoftLimits<S>& limits = p.settings.limits;
  const S share = current_A / limits.current_A;
  const S duty = averaged(s.duty, share * share, dt_s, limits.duty_window_s);
  const S sustained_W = averaged(s.sustained_W, power_W, dt_s, time_constant_s(p));
  s = State{};
  s.duty = duty;
  s.sustained_W = sustained_W;
}

template <class S>
void Controller<S>::enter(State& s, const Mode& mode, const S& strain) {
  s.mode = mode;
  s.entered = true;
  s.rebase = true;
  s.moving = false;
  s.reference = strain;
  s.elapsed_s = S(0);
}

template <class S>
S Controller<S>::clamp(const S& x, const S& low, const S& high, LimitReason why,
                       LimitReasons& reasons) {
  if (x < low || high < x) {
    reasons.add(why);
    return x < low ? low : high;
  }
  return x;
}

/// Clamps the set-point to the soft limits of its mode. Current, power and resistance have no upper
/// bound here, since the limits of the power bound them.
template <class S>
S Controller<S>::limited_setpoint(const Prepared<S>& p, const Demand<S>& demand,
                                  LimitReasons& reasons) {
  const SoftLimits<S>& q = p.settings.limits;
  switch (demand.mode) {
    case Mode::strain:
      return clamp(demand.setpoint, q.min_strain, q.max_strain, LimitReason::strain, reasons);
    case Mode::position: {
      const S length_m = p.settings.wire.geometry.length_m;
      const S zero = p.settings.axis.zero_strain;
      return clamp(demand.setpoint, (zero - q.max_strain) * length_m,
                   (zero - q.min_strain) * length_m, LimitReason::strain, reasons);
    }
    case Mode::temperature:
      return clamp(demand.setpoint, S(0), q.temperature_K - q.hot_spot_K, LimitReason::temperature,
                   reasons);
    case Mode::force:
      return clamp(demand.setpoint, S(0), q.stress_Pa * p.measurement.area_m2, LimitReason::stress,
                   reasons);
    case Mode::current:
      return demand.setpoint < S(0) ? S(0) : demand.setpoint;
    default:
      return demand.setpoint;
  }
}

template <class S>
const LoopGains<S>& Controller<S>::gains(const Settings<S>& q, Mode mode) {
  switch (mode) {
    case Mode::temperature:
      return q.temperature;
    case Mode::resistance:
      return q.resistance;
    case Mode::force:
      return q.force;
    default:
      return q.strain;
  }
}

template <class S>
void Controller<S>::start_loop(const LoopGains<S>& gains, State& s, const S& reference,
                               const S& measured) {
  if (s.entered) {
    s.pid = Pid<S>::start(gains, reference, measured);
  } else if (s.rebase) {
    Pid<S>::resume(gains, s.pid, reference, measured);
  }
}

template <class S>
auto Controller<S>::loop(const Loop& loop, State& s, const Demand<S>& demand, const S& dt_s)
    -> PowerParts {
  start_loop(loop.gains, s, demand.setpoint, loop.measured);
  s.reference = demand.setpoint;
  return {loop.forward_W, Pid<S>::step(loop.gains, demand.scale, loop.direction, s.pid,
                                       demand.setpoint, loop.measured, dt_s)};
}

template <class S>
auto Controller<S>::strain_loop(const Prepared<S>& p, State& s, const Demand<S>& demand,
                                const ControlInputs<S>& known, const S& loss_W,
                                LimitReasons& reasons, const S& dt_s) -> PowerParts {
  const Settings<S>& q = p.settings;
  const S strain = known.estimate.strain;
  start_loop(q.strain, s, s.reference, strain);
  const auto planned =
      Trajectory<S>::step(q.trajectory, s.reference, demand.setpoint, strain, dt_s);
  if (planned.waits) {
    reasons.add(LimitReason::trajectory);
  }
  const S moves = planned.reference - s.reference;
  s.reference = planned.reference;
  const bool arrived =
      !planned.waits && !(s.reference < demand.setpoint) && !(demand.setpoint < s.reference);
  s.moves_1_s = averaged(s.moves_1_s, s.streams && arrived ? moves / dt_s : S(0), dt_s,
                         q.strain.derivative_filter_s);
  s.streams = arrived;
  const S error = s.reference - strain + q.trajectory.lead_s * s.moves_1_s;
  const S size = error < S(0) ? -error : error;
  const S band = q.strain.dead_band;
  // Between the branches of the hysteresis the strain hardly depends on the temperature: inside the
  // dead band the temperature is held. A motion that has begun goes on until the error is below a
  // quarter of the dead band.
  s.moving = band < size || S(0) < moves * error || (s.moving && S(0.25) * band < size);
  S forward_W = loss_W;
  if (planned.waits) {
    forward_W = S(0);
  } else if (s.moving && S(0) < q.feed_forward_s) {
    const S heat_J = FeedForward<S>::heat_J(p, known.filter, error);
    forward_W = loss_W + FeedForward<S>::power_W(heat_J, q.feed_forward_s, dt_s);
  }
  return {forward_W, Pid<S>::step(q.strain, demand.scale, S(-1), s.pid, s.reference, strain, dt_s)};
}

/// The profile's level times the power that holds the wire `overheat_K` above the transformation.
template <class S>
S Controller<S>::profile_W(const Prepared<S>& p, const State& s, const ControlInputs<S>& known) {
  const auto& model = p.observer.model;
  const Isobar<S> m2a = isobar(model.kinetics.m2a, known.filter.stress_Pa);
  const S hot_K = m2a.start_K + S(1) / m2a.per_K + p.settings.profile.overheat_K;
  return Profile<S>::level(p.settings.profile, s.elapsed_s) * known.filter.loss *
         model.body.loss_W(hot_K - known.filter.ambient_K);
}

template <class S>
auto Controller<S>::wanted(const Prepared<S>& p, State& s, const Demand<S>& demand,
                           const ControlInputs<S>& known, const S& ohm, const S& loss_W,
                           LimitReasons& reasons, const S& dt_s) -> PowerParts {
  const Settings<S>& q = p.settings;
  switch (demand.mode) {
    case Mode::off:
      return {S(0), S(0)};
    case Mode::current:
      return {demand.setpoint * demand.setpoint * ohm, S(0)};
    case Mode::power:
      return {demand.setpoint, S(0)};
    case Mode::resistance:
      return loop({q.resistance, S(-1), ohm, loss_W}, s, demand, dt_s);
    case Mode::temperature: {
      const S above_K = demand.setpoint - known.filter.ambient_K;
      const S hold_W = known.filter.loss * p.observer.model.body.loss_W(above_K);
      return loop({q.temperature, S(1), known.estimate.temperature_K, hold_W}, s, demand, dt_s);
    }
    case Mode::force: {
      const S load_N = known.filter.stress_Pa * p.measurement.area_m2;
      return loop({q.force, S(1), load_N, loss_W}, s, demand, dt_s);
    }
    case Mode::identification:
      return {profile_W(p, s, known), S(0)};
    case Mode::strain:
    case Mode::position:
      break;
  }
  Demand<S> strain = demand;
  if (demand.mode == Mode::position) {
    strain.setpoint = q.axis.zero_strain - demand.setpoint / q.wire.geometry.length_m;
  }
  return strain_loop(p, s, strain, known, loss_W, reasons, dt_s);
}

/// Applies the limits twice: to the wanted power, so that transfer_W never exceeds the range, and
/// to the sum of the allowed power and transfer_W.
template <class S>
S Controller<S>::limited_power_W(const Prepared<S>& p, State& s, const Mode& mode,
                                 const PowerRange<S>& range, const PowerParts& wanted,
                                 LimitReasons& reasons, const S& dt_s) {
  const Settings<S>& q = p.settings;
  const S wanted_W = wanted.forward_W + wanted.feedback_W;
  const S allowed_W = range.apply(wanted_W, reasons);
  if (!isfinite(wanted_W)) {
    const S duty = s.duty;
    s = State{};
    s.duty = duty;
    return allowed_W;
  }
  if (s.rebase) {
    s.transfer_W = s.power_W - allowed_W;
    s.entered = s.rebase = false;
  }
  const S given_W = range.within(allowed_W + s.transfer_W);
  s.transfer_W -= s.transfer_W * (dt_s / (dt_s + q.transfer_s));
  // Only the feedback beyond the limits winds the integral back, not the feed-forward, because in
  // every motion the model demands more cooling than is possible.
  const S from_model_W = range.within(wanted.forward_W) + wanted.feedback_W;
  Pid<S>::limited(gains(q, mode), s.pid, from_model_W, range.within(from_model_W), dt_s);
  return given_W;
}

template <class S>
auto Controller<S>::step(const Prepared<S>& p, State& s, const Demand<S>& demand,
                         const ControlInputs<S>& known, const S& dt_s) -> Result {
  using std::sqrt;
  const Settings<S>& q = p.settings;
  const S ohm = known.measurement.resistance_valid ? known.measurement.resistance_ohm
                                                   : known.estimate.resistance_model_ohm;
  const S loss_W = FeedForward<S>::loss_W(p, known.filter);
  const bool known_wire =
      isfinite(ohm + loss_W + known.estimate.strain + known.estimate.temperature_K);
  if (demand.mode == Mode::off || !known_wire) {
    rest(p, s, dt_s);
    return {};
  }
  if (demand.mode != s.mode) {
    enter(s, demand.mode, known.estimate.strain);
  }
  LimitReasons reasons;
  const Demand<S> allowed{demand.mode, limited_setpoint(p, demand, reasons), demand.scale};
  const PowerRange<S> range(p, known, ohm, loss_W, s.duty, s.sustained_W, dt_s);
  const PowerParts want = wanted(p, s, allowed, known, ohm, loss_W, reasons, dt_s);
  s.power_W = limited_power_W(p, s, demand.mode, range, want, reasons, dt_s);
  const S current_A = sqrt(s.power_W / ohm);
  const S share = current_A / q.limits.current_A;
  s.duty = averaged(s.duty, share * share, dt_s, q.limits.duty_window_s);
  s.sustained_W = averaged(s.sustained_W, s.power_W, dt_s, time_constant_s(p));
  s.elapsed_s += dt_s;
  const auto drive =
      CurrentLoop<S>::step(q.drive, s.current_loop, current_A, known.current_A, ohm, dt_s);
  const S reference = demand.mode == Mode::position
                          ? (q.axis.zero_strain - s.reference) * q.wire.geometry.length_m
                      : demand.mode == Mode::strain ? s.reference
                                                    : allowed.setpoint;
  return {drive.current_A,
          drive.voltage_V,
          allowed.setpoint,
          reference,
          s.power_W,
          reasons.bits(),
          !isfinite(want.forward_W + want.feedback_W)};
}

}  // namespace smaservo
