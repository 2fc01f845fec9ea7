#pragma once
// Between a board and the device: frames to inputs, outputs to drive commands. For mains.

#include <cstdint>
#include <limits>

#include "firmware/command.hpp"
#include "hal/board.hpp"

namespace smaservo {

/// Where no frame came nothing was read.
template <class S, class Board>
Inputs<S> inputs_of(const FrameOf<Board>& frame, ReadStatus status) {
  const S none = std::numeric_limits<S>::quiet_NaN();
  Inputs<S> in{};
  in.sample = {none, none, none};
  in.supply_V = in.ambient_K = in.driver_K = none;
  in.fresh = status == ReadStatus::frame;
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

/// Heat is a lease: it ends `lease_ns` after this instant, unless the next step renews it.
template <class Board = double, class S>
DriveCommandOf<Board> drive_of(const Output<S>& output, std::int64_t now_ns,
                               std::int64_t lease_ns) {
  return {static_cast<Board>(output.current_A), static_cast<Board>(output.voltage_V),
          now_ns + lease_ns};
}

}  // namespace smaservo
