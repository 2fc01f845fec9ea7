#pragma once
// What a main does between a board and the device's step. For mains only: nothing else knows the
// board.

#include <limits>

#include "firmware/command.hpp"
#include "hal/board.hpp"

namespace smaservo {

/// A frame as the step wants it; where none came, nothing was read.
template <class S>
Inputs<S> device_inputs(ReadStatus status, const Frame& frame) {
  const S none = std::numeric_limits<S>::quiet_NaN();
  Inputs<S> in{};
  in.fresh = status == ReadStatus::frame;
  if (!in.fresh) {
    in.sample = {none, none, none};
    in.supply_V = in.ambient_K = in.driver_K = none;
    return in;
  }
  in.sequence = frame.sequence;
  in.sample = {static_cast<S>(frame.current_A), static_cast<S>(frame.voltage_V),
               static_cast<S>(frame.load_N)};
  in.supply_V = static_cast<S>(frame.supply_V);
  in.ambient_K = static_cast<S>(frame.ambient_K);
  in.driver_K = static_cast<S>(frame.driver_K);
  in.emergency_stop = frame.emergency_stop;
  in.driver_fault = frame.driver_fault;
  return in;
}

/// What the drive gets: a lease of a few periods, so that heat ends with the loop.
template <class S>
DriveCommand drive_command(const Output<S>& output, std::int64_t now_ns, std::int64_t period_ns) {
  constexpr int leased_periods = 3;
  return {static_cast<double>(output.current_A), static_cast<double>(output.voltage_V),
          now_ns + leased_periods * period_ns};
}

}  // namespace smaservo
