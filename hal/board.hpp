#pragma once
// The contract between the firmware and the machine that it runs on. A main owns a board and moves
// frames, commands and time between it and the firmware's pure steps; nothing else knows it.

#include <concepts>
#include <cstdint>

#include "hal/can_frame.hpp"

namespace smaservo::hal {

/// All readings of one instant. A reading that failed, or that the board can not take, is NaN,
/// never an old or invented number. In the board's own precision.
template <class S>
struct FrameOf {
  std::int64_t time_ns;    ///< monotonic
  std::uint32_t sequence;  ///< counts up by one; a jump is a lost frame
  S current_A;
  S voltage_V;  ///< between the sense leads
  S load_N;
  S supply_V;   ///< of the drive
  S ambient_K;  ///< of the air
  S driver_K;   ///< of the output stage
  bool emergency_stop;
  bool driver_fault;
};
using Frame = FrameOf<double>;

enum class ReadStatus : unsigned char {
  frame,    ///< a new frame was written
  nothing,  ///< none came in its period: time_ns is now, the rest means nothing
  end,      ///< there will be none any more: a replayed trace is over, a device is gone
};

/// Heat is a lease: past its time the board switches off by itself.
template <class S>
struct DriveCommandOf {
  S current_A;  ///< for a drive that takes a current
  S voltage_V;  ///< for one that takes a voltage; a board has one or the other
  std::int64_t valid_until_ns;
};
using DriveCommand = DriveCommandOf<double>;

template <class B, class S = double>
concept Board = requires(B board, FrameOf<S>& frame, const DriveCommandOf<S>& command) {
  /// Waits for the next frame, at most for the board's period and a bit.
  { board.read(frame) } -> std::same_as<ReadStatus>;
  { board.drive(command) } -> std::same_as<void>;
  /// Current off; allowed in any state, any number of times.
  { board.safe_off() } -> std::same_as<void>;
  /// Renews the lease of the hardware that cuts the drive off when it is not kicked for some
  /// milliseconds (a retriggerable one-shot). Once per step that went well, and never else.
  { board.kick() } -> std::same_as<void>;
  /// The clock of Frame::time_ns.
  { board.now_ns() } -> std::same_as<std::int64_t>;
};

/// A CAN controller with its queues. Neither call waits.
template <class P>
concept CanPort = requires(P port, CanFrame& in, const CanFrame& out) {
  /// The oldest frame that has come and was not sent by this port; false: there is none.
  { port.receive(in) } -> std::same_as<bool>;
  /// False: the queue is full or the bus is down. The frame is dropped; the port counts it.
  { port.send(out) } -> std::same_as<bool>;
};

}  // namespace smaservo::hal
