#pragma once
// The contract between the firmware and the machine that it runs on. A main owns a board and moves
// frames, commands and time between it and the firmware's pure steps; nothing else knows it.
// So far: measurements in, drive out, off.

#include <concepts>
#include <cstdint>

namespace smaservo {

/// All readings of one instant. A reading that failed is NaN, never an old or invented number.
struct Frame {
  std::int64_t time_ns;    ///< monotonic
  std::uint32_t sequence;  ///< counts up by one; a jump is a lost frame
  double current_A;
  double voltage_V;  ///< between the sense leads
  double load_N;
};

enum class ReadStatus : unsigned char {
  frame,  ///< a new frame was written
  end,    ///< there will be none any more: a replayed trace is over, a device is gone
};

/// Heat is a lease: past its time the board switches off by itself.
struct DriveCommand {
  double current_A;
  std::int64_t valid_until_ns;
};

template <class B>
concept Board = requires(B board, Frame& frame, const DriveCommand& command) {
  /// Waits for the next frame.
  { board.read(frame) } -> std::same_as<ReadStatus>;
  { board.drive(command) } -> std::same_as<void>;
  /// Current off; allowed in any state, any number of times.
  { board.safe_off() } -> std::same_as<void>;
};

}  // namespace smaservo
