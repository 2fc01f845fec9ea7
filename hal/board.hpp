#pragma once
// The interface between the firmware and the machine that it runs on. A main program owns a board
// and moves frames, commands and time between it and the firmware's pure steps; no other code knows
// the board.

#include <concepts>
#include <cstdint>

#include "hal/can_frame.hpp"

namespace smaservo::hal {

/// All readings of one instant. A reading that failed, or that the board cannot take, is NaN,
/// never an old or invented number. S is the board's own precision.
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
  nothing,  ///< none came in this period: time_ns is now, the rest is meaningless
  end,      ///< no more will come: a replayed trace is over, a device is gone
};

/// A command to the drive. Heat is a lease: after valid_until_ns the board switches off by itself.
template <class S>
struct DriveCommandOf {
  S current_A;  ///< for a drive that takes a current
  S voltage_V;  ///< for a drive that takes a voltage; a board has one or the other
  std::int64_t valid_until_ns;
};
using DriveCommand = DriveCommandOf<double>;

template <class B, class S = double>
concept Board = requires(B board, FrameOf<S>& frame, const DriveCommandOf<S>& command) {
  /// Waits for the next frame, at most for a little more than the board's period.
  { board.read(frame) } -> std::same_as<ReadStatus>;
  { board.drive(command) } -> std::same_as<void>;
  /// Switches the current off; allowed in any state, any number of times.
  { board.safe_off() } -> std::same_as<void>;
  /// Triggers the one-shot, a retriggerable circuit that cuts the drive off some milliseconds after
  /// the last kick. Called once after each step that went well, and never else.
  { board.kick() } -> std::same_as<void>;
  /// The present time, on the clock of Frame::time_ns.
  { board.now_ns() } -> std::same_as<std::int64_t>;
};

/// A CAN controller with its queues. Neither call waits.
template <class P>
concept CanPort = requires(P port, CanFrame& in, const CanFrame& out) {
  /// Takes the oldest frame that has come; false: there is none. Frames sent by this port do not
  /// come back.
  { port.receive(in) } -> std::same_as<bool>;
  /// False: the queue is full or the bus is down. The frame is dropped; the port counts it.
  { port.send(out) } -> std::same_as<bool>;
};

}  // namespace smaservo::hal
