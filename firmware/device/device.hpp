#pragma once
// The firmware, free of hardware: one pure step from sample and command to current.
//
//   inputs -> measure -> observe -> protect -> control -> output
//
// No I/O, clock, heap or exception; the state is a trivially copyable value, and the inputs of all
// steps are the log: replayed, they give the same outputs.

#include <limits>
#include <type_traits>

#include "firmware/command.hpp"
#include "firmware/control/control.hpp"
#include "firmware/prepared.hpp"
#include "firmware/safety/supervisor.hpp"
#include "model/scalar/scalar.hpp"

namespace smaservo {

/// A device as a pure step: all that it remembers is in State.
template <class S>
struct Device {
  using Observer = typename Prepared<S>::Observer;

  /// All that a device remembers; start() makes it.
  struct State {
    typename Observer::State observer;
    typename Monitor<S>::State monitor;
    typename Supervisor<S>::State supervisor;
    typename Controller<S>::State controller;
    bool observing;    ///< there has been a first sample
    S since_sample_s;  ///< age of the last fresh sample
    S since_command_s;
    S off_s;           ///< no current has been given for so long
    S given_before_A;  ///< current given in the step before the last
    std::uint64_t time_us;
    Output<S> last;
  };

  /// As after switching on.
  static State start() { return State{}; }

  /// dt_s since the last step, 0.1 to 20 ms, or longer where the loop stood still. A step after
  /// more than the lease is a stall (timing.hpp): there is no current, the fault loop_stalled, and
  /// the wire is as warm as if the last command had persisted. Order: observe(), then decide().
  /// Cost: after a stall up to 64 steps of the observer.
  static Output<S> step(const Prepared<S>& p, State& s, const Inputs<S>& in,
                        const Command<S>& command, const S& dt_s) {
    const Measurement<S> m = observe(p, s, in, dt_s);
    const Estimate<S> e = estimate(p, s);
    return decide(p, s, in, m, e, command, dt_s);
  }

  /// The first half: what the sample says, and what the observer makes of it.
  static Measurement<S> observe(const Prepared<S>& p, State& s, const Inputs<S>& in, const S& dt_s);
  /// What the observer knows after observe().
  static Estimate<S> estimate(const Prepared<S>& p, const State& s) {
    return Observer::estimate(p.observer, s.observer);
  }

  /// The second half. Experiments may call it with another estimate.
  static Output<S> decide(const Prepared<S>& p, State& s, const Inputs<S>& in,
                          const Measurement<S>& measured, const Estimate<S>& e,
                          const Command<S>& command, const S& dt_s);

 private:
  using Verdict = typename Supervisor<S>::Verdict;

  static bool stalled(const Prepared<S>& p, const S& dt_s) {
    return is_stall(dt_s, p.settings.timing.period_s);
  }
  // Out of line: its memory on the stack must not be a part of each step's.
  [[gnu::noinline]] static Measurement<S> after_stall(const Prepared<S>& p, State& s,
                                                      const S& dt_s);
  static void count_time(const Prepared<S>& p, State& s, const Inputs<S>& in,
                         const Command<S>& command, const S& dt_s);
  static MonitorInputs<S> seen_in_step(const Prepared<S>& p, const State& s, const Inputs<S>& in,
                                       const Measurement<S>& m, const Estimate<S>& e,
                                       const Command<S>& command, const S& dt_s);
  static bool at_stop(const Prepared<S>& p, const State& s, const Measurement<S>& measured,
                      const Estimate<S>& e) {
    return s.observing && S(0) < p.observer.stop_strain && measured.stress_valid &&
           e.health != Health::searching &&
           KalmanObserver<S>::held(MultipleModelFilter<S>::likeliest(s.observer.observer));
  }
  static Verdict protect(const MonitorInputs<S>& seen, State& s);
  static Output<S> without_heat(const MonitorInputs<S>& seen, const State& s, const Verdict& v);
  static void sense(const Prepared<S>& p, Output<S>& out);
  static void control(const MonitorInputs<S>& seen, State& s, const Demand<S>& demand,
                      Output<S>& out);
  static void limit(const Prepared<S>& p, State& s, Output<S>& out);
};

template <class S>
Measurement<S> Device<S>::observe(const Prepared<S>& p, State& s, const Inputs<S>& in,
                                  const S& dt_s) {
  if (stalled(p, dt_s)) [[unlikely]] {
    return after_stall(p, s, dt_s);
  }
  const MeasurementSettings<S>& q = p.settings.measurement;
  Sample<S> sample = s.monitor.zero.corrected(p, in.sample);
  sample.load_N =
      q.has_load_cell ? (sample.load_N - q.load_offset_N) * q.load_gain : q.constant_load_N;
  if (!in.fresh) {
    // Nothing was measured in this interval, so the observer takes the wire as unheated. To go on
    // with the last sample would be the better guess, but would keep a stale sample alive; heating
    // stops after sample_timeout_s.
    Measurement<S> nothing{};
    if (s.observing) {
      Observer::advance(p.observer, s.observer, nothing, dt_s);
    }
    return nothing;
  }
  const Measurement<S> m = measure(p.measurement, sample);
  if (s.observing) {
    Observer::advance(p.observer, s.observer, m, dt_s);
  } else if (m.stress_valid) {
    Observer::start(p.observer, s.observer, m, isfinite(in.ambient_K) ? in.ambient_K : S(room_K));
    s.observing = true;
  }
  return m;
}

/// What was measured last, and what is measured now, say nothing of the time between.
template <class S>
Measurement<S> Device<S>::after_stall(const Prepared<S>& p, State& s, const S& dt_s) {
  const S given_A =
      s.given_before_A < s.last.drive_current_A ? s.last.drive_current_A : s.given_before_A;
  Measurement<S> told{};
  told.power_W = persisting_power_W(p, given_A, s.last.drive_voltage_V);
  told.power_valid = true;
  told.stress_Pa = MultipleModelFilter<S>::likeliest(s.observer.observer).load_Pa;
  if (s.observing) {
    const StalledTime<S> time(p, dt_s);
    for (int i = 0; i < time.parts; ++i) {
      MultipleModelFilter<S>::advance(p.observer, s.observer.observer, told, time.part_s);
    }
    s.observer.last = told;
  }
  return told;
}

template <class S>
Output<S> Device<S>::decide(const Prepared<S>& p, State& s, const Inputs<S>& in,
                            const Measurement<S>& measured, const Estimate<S>& e,
                            const Command<S>& command, const S& dt_s) {
  count_time(p, s, in, command, dt_s);
  Measurement<S> m = measured;
  const bool stopped = at_stop(p, s, measured, e);
  if (stopped) {
    m.stress_Pa = MultipleModelFilter<S>::likeliest(s.observer.observer).stress_Pa;
  }
  const MonitorInputs<S> seen = seen_in_step(p, s, in, m, e, command, dt_s);
  const Verdict v = protect(seen, s);
  Output<S> out = without_heat(seen, s, v);
  const bool safe = v.heat == Heat::hold || v.heat == Heat::release;
  if (v.heat == Heat::sense) {
    sense(p, out);
  }
  if (safe || (v.heat == Heat::run && command.mode != Mode::off)) {
    control(seen, s,
            safe ? Demand<S>{Mode::strain, v.strain, {}}
                 : Demand<S>{command.mode, command.setpoint, command.scale},
            out);
    if (v.limited) {
      limit(p, s, out);
    }
    out.limit_reasons |= (v.warnings & limiting_faults).empty()
                             ? 0U
                             : 1U << static_cast<unsigned>(LimitReason::protection);
  } else if (seen.stalled) [[unlikely]] {
    Controller<S>::persist(p, s.controller, seen.max_given_A(), m.power_W, dt_s);
  } else {
    Controller<S>::rest(p, s.controller, dt_s);
  }
  out.measurement = measured;
  out.at_stop = stopped;
  s.given_before_A = s.last.drive_current_A;
  s.last = out;
  return out;
}

template <class S>
void Device<S>::count_time(const Prepared<S>& p, State& s, const Inputs<S>& in,
                           const Command<S>& command, const S& dt_s) {
  const S longest_s = S(longest_stall_s);
  const S counted_s = dt_s < longest_s ? dt_s : longest_s;
  // A float that counts seconds would stand still after some hours.
  s.time_us += static_cast<std::uint32_t>(static_cast<int>(counted_s * S(1e6) + S(0.5)));
  s.since_sample_s = in.fresh ? S(0) : s.since_sample_s + dt_s;
  s.since_command_s = command.fresh ? S(0) : s.since_command_s + dt_s;
  const S off_s = stalled(p, dt_s) ? StalledTime<S>(p, dt_s).all_s : dt_s;
  s.off_s = s.last.drive_current_A == S(0) ? s.off_s + off_s : S(0);
}

template <class S>
MonitorInputs<S> Device<S>::seen_in_step(const Prepared<S>& p, const State& s, const Inputs<S>& in,
                                         const Measurement<S>& m, const Estimate<S>& e,
                                         const Command<S>& command, const S& dt_s) {
  const Sample<S> sample = s.monitor.zero.corrected(p, in.sample);
  return {.prepared = p,
          .in = in,
          .command = command,
          .measurement = m,
          .estimate = e,
          .filter = MultipleModelFilter<S>::likeliest(s.observer.observer),
          .last = s.last,
          .given_before_A = s.given_before_A,
          .current_A = sample.current_A - p.settings.measurement.current_offset_A,
          .voltage_V = sample.voltage_V - p.settings.measurement.voltage_offset_V,
          .duty = s.controller.duty,
          .off_s = s.off_s,
          .since_sample_s = s.since_sample_s,
          .since_command_s = s.since_command_s,
          .dt_s = dt_s,
          .observing = s.observing,
          .zeroed = s.monitor.zero.known(),
          .stalled = stalled(p, dt_s)};
}

template <class S>
auto Device<S>::protect(const MonitorInputs<S>& seen, State& s) -> Verdict {
  const FaultSet active = Monitor<S>::step(seen, s.monitor);
  if (s.observing && !isfinite(seen.estimate.strain + seen.estimate.temperature_K)) {
    s.observing = false;  // NaN would never leave the observer: the next sample starts it anew
  }
  return Supervisor<S>::step(seen, s.supervisor, active, s.time_us);
}

/// The output of this verdict before any current is computed.
template <class S>
Output<S> Device<S>::without_heat(const MonitorInputs<S>& seen, const State& s, const Verdict& v) {
  const S hot_spot_K = seen.prepared.settings.limits.hot_spot_K;
  return {.drive_current_A = S(0),
          .drive_voltage_V = S(0),
          .state = v.state,
          .mode = Mode::off,
          .setpoint = S(0),
          .reference = S(0),
          .wanted_power_W = S(0),
          .measurement = seen.measurement,
          .estimate = seen.estimate,
          .estimated_ambient_K = seen.filter.ambient_K,
          .hot_spot_K = seen.estimate.temperature_K + hot_spot_K,
          .limit_reasons = 0,
          .active = v.active,
          .latched = v.latched,
          .first_cause = s.supervisor.first_cause,
          .warnings = v.warnings,
          .told_count = s.supervisor.warnings.told(),
          .blocks = v.blocks,
          .time_us = s.time_us,
          .first_cause_us = s.supervisor.first_cause_us,
          .cooling = s.monitor.wire.cooling.known(),
          .wire_stress_Pa = seen.filter.stress_Pa,
          .at_stop = false};
}

/// Before the wire has been checked. parameter_check.hpp keeps this current below limits.power_W.
template <class S>
void Device<S>::sense(const Prepared<S>& p, Output<S>& out) {
  out.drive_current_A = p.settings.limits.min_current_A;
  out.drive_voltage_V = out.drive_current_A * p.cold_ohm;
}

/// A result that is not usable as a current is not put out; the next step reports control_invalid.
template <class S>
void Device<S>::control(const MonitorInputs<S>& seen, State& s, const Demand<S>& demand,
                        Output<S>& out) {
  const ControlInputs<S> known{seen.measurement,
                               seen.estimate,
                               seen.filter,
                               seen.current_A,
                               seen.in.supply_V,
                               seen.in.ambient_K,
                               s.monitor.wire.hot.temperature_K,
                               s.monitor.wire.cooling.limit_K(),
                               s.monitor.wire.cooling.probing()};
  const auto c = Controller<S>::step(seen.prepared, s.controller, demand, known, seen.dt_s);
  const bool usable = !c.invalid && S(0) <= c.drive_current_A &&
                      c.drive_current_A <= seen.prepared.settings.trips.current_A &&
                      isfinite(c.drive_voltage_V);
  s.monitor.machine.control_invalid = !usable;
  if (!usable) {
    return;
  }
  out.drive_current_A = c.drive_current_A;
  out.drive_voltage_V = c.drive_voltage_V;
  out.mode = demand.mode;
  out.setpoint = c.setpoint;
  out.reference = c.reference;
  out.wanted_power_W = c.wanted_power_W;
  out.limit_reasons = c.limit_reasons;
}

/// Limits the current to limits.min_current_A, which keeps the resistance measurable, and tells the
/// controller what was given.
template <class S>
void Device<S>::limit(const Prepared<S>& p, State& s, Output<S>& out) {
  const S min_A = p.settings.limits.min_current_A;
  if (!(min_A < out.drive_current_A)) {
    return;
  }
  const S share = min_A / out.drive_current_A;
  out.drive_current_A = min_A;
  out.drive_voltage_V *= share;
  out.wanted_power_W = out.wanted_power_W * share * share;
  s.controller.current_loop.asked_A = out.drive_current_A;
  s.controller.power_W = out.wanted_power_W;
}

static_assert(std::is_trivially_copyable_v<Device<float>::State>);

}  // namespace smaservo
