#pragma once
// The device's step, on inputs that were recorded in a closed loop.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/bench/cycle.hpp"
#include "tests/firmware/device/test_device.hpp"

namespace smaservo::benchmarks {

/// One instant of the closed loop.
template <class S>
struct Moment {
  Inputs<S> inputs;
  Command<S> command;
  // What the controller gets.
  Measurement<S> measurement;
  Estimate<S> estimate;
  typename KalmanObserver<S>::State filter;
};

/// A wire under 150 MPa that follows a strain: up and down in steps, with rests, and back. Begins
/// and ends in the same state.
template <class S>
class Recording {
 public:
  Recording() { record(); }

  Prepared<S> prepared = prepare(test_settings<S>());
  typename Device<S>::State state = Device<S>::start();
  typename Device<S>::State begin{};  ///< state at the beginning of the recorded moments
  std::vector<Moment<S>> moments;

 private:
  void record() {
    TestBench wire(files::load_wire(std::string(files::default_wire)).wire, 150e6);
    const double longest = wire.strain();
    run(wire, longest);
    begin = state;
    moments.clear();
    run(wire, longest);
  }
  void run(TestBench& wire, double longest) {
    for (const double contraction : {0.01, 0.03, 0.02, 0.035, 0.005, 0.025, 0.0}) {
      for (int i = 0; i < 600; ++i) {
        Moment<S> now{};
        now.inputs = wire.inputs<S>();
        now.command = {.fresh = true,
                       .arm = true,
                       .mode = Mode::strain,
                       .setpoint = scalar<S>(longest - contraction)};
        const Output<S> out = Device<S>::step(prepared, state, now.inputs, now.command, S(1e-3));
        now.measurement = out.measurement;
        now.estimate = out.estimate;
        now.filter = state.observer.observer.filter[0];
        wire.advance(static_cast<double>(out.drive_current_A), 1e-3);
        moments.push_back(now);
      }
    }
  }
};

/// Measure, observe, protect and control.
template <class S>
class DeviceStep {
 public:
  DeviceStep() : DeviceStep(Recording<S>()) {}
  std::size_t period() const { return moments_.size(); }
  void operator()() {
    const Moment<S>& now = moments_.next();
    inputs_ = now.inputs;
    inputs_.sequence = sequence_++;
    Device<S>::step(prepared_, state_, inputs_, now.command, S(1e-3));
  }

 private:
  explicit DeviceStep(const Recording<S>& recording)
      : prepared_(recording.prepared), moments_(recording.moments), state_(recording.begin) {}

  Prepared<S> prepared_;
  Cycle<Moment<S>> moments_;
  typename Device<S>::State state_;
  Inputs<S> inputs_{};
  std::uint32_t sequence_ = 1U << 30U;
};

/// The controller alone.
template <class S>
class ControlStep {
 public:
  ControlStep() : ControlStep(Recording<S>()) {}
  std::size_t period() const { return moments_.size(); }
  void operator()() {
    const Moment<S>& now = moments_.next();
    const ControlInputs<S> known{now.measurement, now.estimate, now.filter,
                                 now.inputs.sample.current_A, now.inputs.supply_V};
    Controller<S>::step(prepared_, state_,
                        {now.command.mode, now.command.setpoint, now.command.scale}, known,
                        S(1e-3));
  }

 private:
  explicit ControlStep(const Recording<S>& recording)
      : prepared_(recording.prepared),
        moments_(recording.moments),
        state_(recording.begin.controller) {}

  Prepared<S> prepared_;
  Cycle<Moment<S>> moments_;
  typename Controller<S>::State state_;
};

template <class S, class F>
void for_each_device_step(F f) {
  f("control_step", [] { return ControlStep<S>(); });
  f("device_step", [] { return DeviceStep<S>(); });
}

}  // namespace smaservo::benchmarks
