#pragma once
// The firmware, free of hardware: one pure step from sample and command to current.
//
//   inputs -> measure -> observe -> protect -> control -> output
//
// No I/O, clock, heap or exception; the state is a trivially copyable value, and the inputs of the
// steps are the log: given again, they give the same outputs.

#include <cmath>
#include <limits>
#include <type_traits>

#include "firmware/command.hpp"
#include "firmware/control.hpp"
#include "firmware/prepared.hpp"

namespace smaservo {

template <class S>
struct Device {
  using Observer = typename Prepared<S>::Observer;

  struct State {
    typename Observer::State observer;
    typename Controller<S>::State controller;
    DeviceState state;
    bool observing;    ///< there has been a first sample
    S since_sample_s;  ///< age of the last fresh sample
    Output<S> last;
  };

  /// As after switching on.
  static State start() {
    State s{};
    s.state = DeviceState::starting;
    return s;
  }

  /// dt_s since the last step, 0.1 to 20 ms. Order: observe(), then decide().
  static Output<S> step(const Prepared<S>& p, State& s, const Inputs<S>& in,
                        const Command<S>& command, const S& dt_s) {
    const Measurement<S> m = observe(p, s, in, dt_s);
    const Estimate<S> e = estimate(p, s);
    return decide(p, s, in, m, e, command, dt_s);
  }

  /// The first half: what the sample says, and what the observer makes of it.
  static Measurement<S> observe(const Prepared<S>& p, State& s, const Inputs<S>& in, const S& dt_s);
  static Estimate<S> estimate(const Prepared<S>& p, const State& s) {
    return Observer::estimate(p.observer, s.observer);
  }

  /// The second half, open to experiments with another estimate.
  static Output<S> decide(const Prepared<S>& p, State& s, const Inputs<S>& in,
                          const Measurement<S>& m, const Estimate<S>& e, const Command<S>& command,
                          const S& dt_s);
};

template <class S>
Measurement<S> Device<S>::observe(const Prepared<S>& p, State& s, const Inputs<S>& in,
                                  const S& dt_s) {
  const Measuring<S>& q = p.settings.measuring;
  Sample<S> sample = in.sample;
  sample.load_N =
      q.has_load_cell ? (sample.load_N - q.load_offset_N) * q.load_gain : q.constant_load_N;
  if (!in.fresh) {
    // Nothing is known of this interval. That the wire was not heated is the worse guess, but the
    // only one that a stale sample must not keep alive; heating stops after sample_timeout_s.
    Measurement<S> nothing{};
    if (s.observing) {
      Observer::advance(p.observer, s.observer, nothing, dt_s);
    }
    return nothing;
  }
  const Measurement<S> m = measure(p.measuring, sample);
  if (s.observing) {
    Observer::advance(p.observer, s.observer, m, dt_s);
  } else if (m.stress_valid) {
    const S room_K = S(298.15);
    s.observer =
        Observer::start(p.observer, m, std::isfinite(in.ambient_K) ? in.ambient_K : room_K);
    s.observing = true;
  }
  return m;
}

template <class S>
Output<S> Device<S>::decide(const Prepared<S>& p, State& s, const Inputs<S>& in,
                            const Measurement<S>& m, const Estimate<S>& e,
                            const Command<S>& command, const S& dt_s) {
  const auto& filter = s.observer.observer.filter[0];
  Output<S> out{};
  out.measurement = m;
  out.estimate = e;
  out.ambient_K = filter.ambient_K;
  const bool heat = s.observing && command.arm && command.mode != Mode::off && !in.emergency_stop;
  s.state = heat ? DeviceState::running : DeviceState::ready;
  out.state = s.state;
  if (heat) {
    const Known<S> known{m, e, filter, in.sample.current_A, in.supply_V};
    const auto c = Controller<S>::step(
        p, s.controller, {command.mode, command.setpoint, command.scale}, known, dt_s);
    out.current_A = c.current_A;
    out.voltage_V = c.voltage_V;
    out.mode = command.mode;
    out.setpoint = c.setpoint;
    out.reference = c.reference;
    out.power_W = c.power_W;
    out.limit_reasons = c.limit_reasons;
  } else {
    Controller<S>::rest(p, s.controller, dt_s);
    out.mode = Mode::off;
  }
  s.last = out;
  return out;
}

static_assert(std::is_trivially_copyable_v<Device<float>::State>);

}  // namespace smaservo
