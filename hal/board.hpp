#pragma once
// The interface between the firmware and the machine that it runs on. A main program owns a board
// and moves frames, commands and time between it and the firmware's pure steps; no other code uses
// the board.

#include <concepts>
#include <cstdint>

#include "hal/can_frame.hpp"

namespace smaservo::hal {

/// All readings of one instant. A reading that failed, or that the board cannot take, is NaN, never
/// an old or invented number. S is the board's own precision.
template <class S>
struct FrameOf {
  std::int64_t time_ns;    ///< monotonic time of the readings
  std::uint32_t sequence;  ///< counts up by one; a jump is a lost frame
  S current_A;
  S voltage_V;  ///< voltage between the sense leads
  S load_N;
  S supply_V;   ///< supply voltage of the drive
  S ambient_K;  ///< temperature of the air
  S driver_K;   ///< temperature of the output stage
  bool emergency_stop;
  bool driver_fault;
};
using Frame = FrameOf<double>;

enum class ReadStatus : unsigned char {
  frame,    ///< a new frame was written
  nothing,  ///< no frame came in this period: time_ns is the present time, the rest is meaningless
  end,      ///< no more frames will come: a replayed trace is over, a device is gone
};

/// A command to the drive. Heat is a lease: after valid_until_ns the board switches the drive off
/// by itself.
template <class S>
struct DriveCommandOf {
  S current_A;  ///< command to a drive that takes a current
  S voltage_V;  ///< command to a drive that takes a voltage; a board has one kind of drive only
  std::int64_t valid_until_ns;
};
using DriveCommand = DriveCommandOf<double>;

template <class B, class S = double>
concept Board = requires(B board, FrameOf<S>& frame, const DriveCommandOf<S>& command) {
  /// Waits for the next frame, at most a little longer than the board's period.
  { board.read(frame) } -> std::same_as<ReadStatus>;
  { board.drive(command) } -> std::same_as<void>;
  /// Switches the current off; allowed in any state, any number of times.
  { board.safe_off() } -> std::same_as<void>;
  /// Triggers the one-shot, a retriggerable circuit that cuts the drive off some milliseconds after
  /// the last kick. Called after each step that heats and has had a new frame, and at no other
  /// time.
  { board.kick() } -> std::same_as<void>;
  /// The present time, on the clock of Frame::time_ns.
  { board.now_ns() } -> std::same_as<std::int64_t>;
};

/// A CAN controller with its queues. Neither call blocks.
template <class P>
concept CanPort = requires(P port, CanFrame& in, const CanFrame& out) {
  /// Takes the oldest received frame; false if there is none. Frames sent by this port are not
  /// received.
  { port.receive(in) } -> std::same_as<bool>;
  /// False if the queue is full or the bus is down: the frame is then dropped and counted by the
  /// port.
  { port.send(out) } -> std::same_as<bool>;
};

}  // namespace smaservo::hal
