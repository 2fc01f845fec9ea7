#pragma once
// One cycle of a device on a board, the same for every main: frame to inputs, step, drive. A main
// reads the frame before the cycle, and reports the result after it.

#include <cstdint>
#include <limits>
#include <new>

#include "firmware/command.hpp"
#include "firmware/timing.hpp"
#include "hal/board.hpp"

namespace smaservo {

/// What a main hands to a cycle.
template <class S>
struct Heard {
  Command<S> command;
  FaultSet external;  ///< for Inputs::external
  bool late = false;  ///< for Inputs::deadline_missed
  /// Number of set-points that a master has sent since the cycle before; the last one is used.
  std::uint32_t setpoints = 0;
};

/// The inputs and the result of a cycle.
template <class S>
struct DeviceStep {
  Inputs<S> inputs;
  Command<S> command;
  Output<S> output;
};

/// One step of the device, and its time.
struct Cycle : DeviceStep<double> {
  double time_s;
};

/// Inputs from a frame; without a frame every reading is NaN.
template <class S, class Number>
Inputs<S> inputs_of(const hal::FrameOf<Number>& frame, hal::ReadStatus status) {
  const S none = std::numeric_limits<S>::quiet_NaN();
  Inputs<S> in{};
  in.sample = {none, none, none};
  in.supply_V = in.ambient_K = in.driver_K = none;
  in.fresh = status == hal::ReadStatus::frame;
  if (!in.fresh) {
    return in;
  }
  in.sequence = frame.sequence;
  in.sample = {S(frame.current_A), S(frame.voltage_V), S(frame.load_N)};
  in.supply_V = S(frame.supply_V);
  in.ambient_K = S(frame.ambient_K);
  in.driver_K = S(frame.driver_K);
  in.emergency_stop = frame.emergency_stop;
  in.driver_fault = frame.driver_fault;
  return in;
}

/// `step(inputs, command)` gives the device's Output. Every cycle renews the lease; only one that
/// heats and has read a frame kicks the hardware's one-shot.
template <class B, class S, class Number, class Step>
  requires hal::Board<B, Number>
void run_cycle(B& board, const hal::FrameOf<Number>& frame, hal::ReadStatus status,
               const Heard<S>& heard, std::int64_t period_ns, DeviceStep<S>& now, Step step) {
  now.command = heard.command;
  now.inputs = inputs_of<S>(frame, status);
  now.inputs.deadline_missed = heard.late;
  now.inputs.external = heard.external;
  // Constructed in place: copying the output takes 8 % of the whole step.
  ::new (&now.output) Output<S>(step(now.inputs, now.command));
  const Output<S>& out = now.output;
  board.drive({static_cast<Number>(out.drive_current_A), static_cast<Number>(out.drive_voltage_V),
               board.now_ns() + leased_periods * period_ns});
  if (status == hal::ReadStatus::frame && is_heated(out.state)) {
    board.kick();
  }
}

}  // namespace smaservo
