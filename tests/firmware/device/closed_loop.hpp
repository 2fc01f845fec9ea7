#pragma once
// A controller in closed loop with a lumped wire, without the states and faults of a device.

#include <cmath>
#include <functional>
#include <type_traits>

#include "tests/firmware/device/test_device.hpp"

namespace smaservo {

/// Every part of the law in the strain loop.
inline Settings<double> settings_with_pid() {
  Settings<double> settings = test_settings();
  settings.strain.proportional = 2;
  settings.strain.integral_1_s = 2;
  settings.strain.derivative_s = 0.002;
  return settings;
}

template <class S = double>
class ClosedLoop {
 public:
  using Result = typename Controller<S>::Result;

  explicit ClosedLoop(const Settings<S>& settings, double start_Pa = 150e6)
      : wire(files::load_wire("smartflex-76um").wire, start_Pa), prepared_(prepare(settings)) {
    const Inputs<S> in = wire.inputs<S>();
    state_ = Observer::start(prepared_.observer, measure(prepared_.measurement, in.sample),
                             static_cast<S>(room_K));
  }

  /// One sample, observed and answered.
  Result step(Mode mode, double setpoint, double dt_s = 1e-3) {
    const Inputs<S> in = wire.inputs<S>();
    const Measurement<S> m = observe(in, static_cast<S>(dt_s));
    const Estimate<S> e = estimate();
    const typename KalmanObserver<S>::State f = filter();
    const ControlInputs<S> known{m, e, f, in.sample.current_A, in.supply_V};
    const Result result = Controller<S>::step(
        prepared_, control, {mode, static_cast<S>(setpoint), scale}, known, static_cast<S>(dt_s));
    wire.stress(load_Pa(wire.strain()));
    wire.advance(static_cast<double>(result.drive_current_A), dt_s);
    time_s += dt_s;
    return result;
  }
  /// Calls f(result) after every step.
  template <class F>
  void run(double seconds, Mode mode, double setpoint, F f, double dt_s = 1e-3) {
    for (int i = 0; i < std::lround(seconds / dt_s); ++i) {
      f(step(mode, setpoint, dt_s));
    }
  }
  void run(double seconds, Mode mode, double setpoint, double dt_s = 1e-3) {
    run(seconds, mode, setpoint, [](const Result&) {}, dt_s);
  }

  /// Takes new settings, as if a user had sent them.
  void adopt(const Settings<S>& settings) {
    prepared_ = prepare(settings);
    Controller<S>::adopt(control);
  }

  Estimate<S> estimate() const {
    Estimate<S> e = Observer::estimate(prepared_.observer, state_);
    if (ideal_sensor) {
      e.strain = static_cast<S>(wire.strain());
      e.temperature_K = static_cast<S>(wire.temperature_K());
    }
    return e;
  }
  const Prepared<S>& prepared() const { return prepared_; }

  /// Sets a spring as the load; `stiffness_Pa` is the stress that it would gain over a contraction
  /// of 1.
  void against_spring(double stiffness_Pa) {
    load_Pa = [=, from_Pa = wire.stress_Pa(), longest = wire.strain()](double strain) {
      return from_Pa + stiffness_Pa * (longest - strain);
    };
  }

  TestBench wire;
  typename Controller<S>::State control{};
  GainScale<S> scale{};
  double time_s = 0;
  /// The controller gets the wire's true strain and temperature instead of the estimates. Only for
  /// S = double.
  bool ideal_sensor = false;
  /// What the wire carries, by its strain.
  std::function<double(double)> load_Pa = [same = wire.stress_Pa()](double) { return same; };

 private:
  typename KalmanObserver<S>::State filter() const {
    typename KalmanObserver<S>::State f = state_.observer.filter[0];
    if constexpr (std::is_same_v<S, double>) {
      if (ideal_sensor) {
        f.kinetics = wire.state().kinetics;
        f.stress_Pa = wire.stress_Pa();
        f.ambient_K = room_K;
        f.loss = 1;
      }
    }
    return f;
  }

  using Observer = typename Prepared<S>::Observer;

  Measurement<S> observe(const Inputs<S>& in, const S& dt_s) {
    const Measurement<S> m = measure(prepared_.measurement, in.sample);
    Observer::advance(prepared_.observer, state_, m, dt_s);
    return m;
  }

  Prepared<S> prepared_;
  typename Observer::State state_{};
};

}  // namespace smaservo
