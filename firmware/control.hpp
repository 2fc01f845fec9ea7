#pragma once
// From an estimate and a set-point to the current of the next step. Every mode asks for heating
// power; limits, the transfer between modes and the current loop are the same for all.

#include <cmath>

#include "firmware/command.hpp"
#include "firmware/current_loop.hpp"
#include "firmware/feed_forward.hpp"
#include "firmware/pid.hpp"
#include "firmware/prepared.hpp"
#include "firmware/profile.hpp"
#include "firmware/soft_limits.hpp"
#include "firmware/trajectory.hpp"

namespace smaservo {

/// What is asked of the controller.
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
    bool rebase;  ///< mode or settings are new: the output is not to jump
    bool moving;  ///< towards the reference, until it is reached
    typename Pid<S>::State pid;
    typename CurrentLoop<S>::State current_loop;
    S reference;   ///< of the trajectory
    S power_W;     ///< given in the last step
    S transfer_W;  ///< what the last change would have made jump; fades
    S duty;        ///< average of the squared share of the current limit
    S elapsed_s;   ///< in this mode
  };

  struct Result {
    S current_A, voltage_V;
    S setpoint;   ///< within the limits
    S reference;  ///< of the trajectory, in the set-point's unit
    S power_W;
    std::uint32_t limit_reasons;
  };

  /// No current: the loop starts afresh afterwards.
  static void rest(const Prepared<S>& p, State& s, const S& dt_s);

  /// New settings are in force from the next step on.
  static void adopt(State& s) { s.rebase = true; }

  static Result step(const Prepared<S>& p, State& s, const Demand<S>& demand, const Known<S>& known,
                     const S& dt_s);

 private:
  struct Loop {
    const LoopGains<S>& gains;
    S direction;  ///< +1 where heat raises the variable
    S measured;
    S forward_W;
  };

  static void enter(State& s, const Mode& mode, const S& strain);
  static S limited_setpoint(const Prepared<S>& p, const Demand<S>& demand, LimitReasons& reasons);
  static S wanted_W(const Prepared<S>& p, State& s, const Demand<S>& demand, const Known<S>& known,
                    const S& ohm, const S& loss_W, LimitReasons& reasons, const S& dt_s);
  static S loop_W(const Loop& loop, State& s, const Demand<S>& demand, const S& dt_s);
  static S strain_W(const Prepared<S>& p, State& s, const Demand<S>& demand, const Known<S>& known,
                    const S& loss_W, LimitReasons& reasons, const S& dt_s);
  static S profile_W(const Prepared<S>& p, const State& s, const Known<S>& known);
  static const LoopGains<S>& gains(const Settings<S>& q, Mode mode);
  static S clamp(const S& x, const S& low, const S& high, LimitReason why, LimitReasons& reasons);
};

template <class S>
void Controller<S>::rest(const Prepared<S>& p, State& s, const S& dt_s) {
  const S duty = s.duty - s.duty * (dt_s / (dt_s + p.settings.limits.duty_window_s));
  s = State{};
  s.duty = duty;
}

template <class S>
void Controller<S>::enter(State& s, const Mode& mode, const S& strain) {
  s.mode = mode;
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

/// What the output would be limited by anyway is not limited here.
template <class S>
S Controller<S>::limited_setpoint(const Prepared<S>& p, const Demand<S>& demand,
                                  LimitReasons& reasons) {
  const SoftLimits<S>& q = p.settings.limits;
  switch (demand.mode) {
    case Mode::strain:
      return clamp(demand.setpoint, q.least_strain, q.greatest_strain, LimitReason::strain,
                   reasons);
    case Mode::position: {
      const S length_m = p.settings.wire.geometry.length_m;
      const S zero = p.settings.axis.zero_strain;
      return clamp(demand.setpoint, (zero - q.greatest_strain) * length_m,
                   (zero - q.least_strain) * length_m, LimitReason::strain, reasons);
    }
    case Mode::temperature:
      return clamp(demand.setpoint, S(0), q.temperature_K - q.hot_spot_K, LimitReason::temperature,
                   reasons);
    case Mode::force:
      return clamp(demand.setpoint, S(0), q.stress_Pa * p.measuring.area_m2, LimitReason::stress,
                   reasons);
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
S Controller<S>::loop_W(const Loop& loop, State& s, const Demand<S>& demand, const S& dt_s) {
  if (s.rebase) {
    s.pid = Pid<S>::start(loop.measured, demand.setpoint);
  }
  s.reference = demand.setpoint;
  return loop.forward_W + Pid<S>::step(loop.gains, demand.scale, loop.direction, s.pid,
                                       demand.setpoint, loop.measured, dt_s);
}

template <class S>
S Controller<S>::strain_W(const Prepared<S>& p, State& s, const Demand<S>& demand,
                          const Known<S>& known, const S& loss_W, LimitReasons& reasons,
                          const S& dt_s) {
  const Settings<S>& q = p.settings;
  const S strain = known.estimate.strain;
  if (s.rebase) {
    s.pid = Pid<S>::start(strain, s.reference);
  }
  const auto planned =
      Trajectory<S>::step(q.trajectory, s.reference, demand.setpoint, strain, dt_s);
  if (planned.waits) {
    reasons.add(LimitReason::trajectory);
  }
  const S moves = planned.reference - s.reference;
  s.reference = planned.reference;
  const S error = s.reference - strain;
  const S size = error < S(0) ? S(0) - error : error;
  const S band = q.strain.dead_band;
  // Between the branches of the hysteresis a wire keeps its strain: inside of the band its
  // temperature is held. A motion that has begun goes on to the middle of the band.
  s.moving = band < size || S(0) < moves * error || (s.moving && S(0.25) * band < size);
  const S forward_W = s.moving && S(0) < q.feed_forward_s
                          ? FeedForward<S>::heat_J(p, known.filter, error) / q.feed_forward_s
                          : S(0);
  return loss_W + forward_W +
         Pid<S>::step(q.strain, demand.scale, S(-1), s.pid, s.reference, strain, dt_s);
}

/// The power that ends `overheat_K` above the transformation, by the profile's level.
template <class S>
S Controller<S>::profile_W(const Prepared<S>& p, const State& s, const Known<S>& known) {
  const auto& model = p.observer.model;
  const Isobar<S> m2a = isobar(model.kinetics.m2a, known.filter.stress_Pa);
  const S hot_K = m2a.start_K + S(1) / m2a.per_K + p.settings.profile.overheat_K;
  return Profile<S>::level(p.settings.profile, s.elapsed_s) * known.filter.loss *
         model.body.loss_W(hot_K - known.filter.ambient_K);
}

template <class S>
S Controller<S>::wanted_W(const Prepared<S>& p, State& s, const Demand<S>& demand,
                          const Known<S>& known, const S& ohm, const S& loss_W,
                          LimitReasons& reasons, const S& dt_s) {
  const Settings<S>& q = p.settings;
  switch (demand.mode) {
    case Mode::off:
      return S(0);
    case Mode::current:
      return demand.setpoint * demand.setpoint * ohm;
    case Mode::power:
      return demand.setpoint;
    case Mode::resistance:
      return loop_W({q.resistance, S(-1), ohm, loss_W}, s, demand, dt_s);
    case Mode::temperature: {
      const S above_K = demand.setpoint - known.filter.ambient_K;
      const S hold_W = known.filter.loss * p.observer.model.body.loss_W(above_K);
      return loop_W({q.temperature, S(1), known.estimate.temperature_K, hold_W}, s, demand, dt_s);
    }
    case Mode::force: {
      const S load_N = known.filter.stress_Pa * p.measuring.area_m2;
      return loop_W({q.force, S(1), load_N, loss_W}, s, demand, dt_s);
    }
    case Mode::identification:
      return profile_W(p, s, known);
    case Mode::strain:
    case Mode::position:
      break;
  }
  Demand<S> strain = demand;
  if (demand.mode == Mode::position) {
    strain.setpoint = q.axis.zero_strain - demand.setpoint / q.wire.geometry.length_m;
  }
  return strain_W(p, s, strain, known, loss_W, reasons, dt_s);
}

template <class S>
auto Controller<S>::step(const Prepared<S>& p, State& s, const Demand<S>& demand,
                         const Known<S>& known, const S& dt_s) -> Result {
  using std::sqrt;
  const Settings<S>& q = p.settings;
  const S ohm = known.measurement.resistance_valid ? known.measurement.resistance_ohm
                                                   : known.estimate.resistance_model_ohm;
  const S loss_W = FeedForward<S>::loss_W(p, known.filter);
  if (demand.mode != s.mode) {
    enter(s, demand.mode, known.estimate.strain);
  }
  LimitReasons reasons;
  const Demand<S> allowed{demand.mode, limited_setpoint(p, demand, reasons), demand.scale};
  const S wanted = wanted_W(p, s, allowed, known, ohm, loss_W, reasons, dt_s);
  if (s.rebase) {
    s.transfer_W = s.power_W - wanted;
    s.rebase = false;
  }
  const S sum_W = wanted + s.transfer_W;
  s.transfer_W = s.transfer_W - s.transfer_W * (dt_s / (dt_s + q.transfer_s));
  s.power_W = PowerRange<S>(p, known, ohm, loss_W, s.duty).apply(sum_W, reasons);
  Pid<S>::limited(gains(q, demand.mode), s.pid, sum_W, s.power_W, dt_s);
  const S current_A = sqrt(s.power_W / ohm);
  const S share = current_A / q.limits.current_A;
  s.duty = s.duty + (share * share - s.duty) * (dt_s / (dt_s + q.limits.duty_window_s));
  s.elapsed_s = s.elapsed_s + dt_s;
  const auto drive =
      CurrentLoop<S>::step(q.drive, s.current_loop, current_A, known.measured_A, ohm, dt_s);
  const S reference = demand.mode == Mode::position
                          ? (q.axis.zero_strain - s.reference) * q.wire.geometry.length_m
                      : demand.mode == Mode::strain ? s.reference
                                                    : allowed.setpoint;
  return {drive.current_A, drive.voltage_V, allowed.setpoint, reference, s.power_W, reasons.bits()};
}

}  // namespace smaservo
