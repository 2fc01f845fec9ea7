#pragma once
// A board that wraps any other board and injects faults, for tests.

#include <cstdint>
#include <limits>
#include <utility>

#include "hal/board.hpp"

namespace smaservo::hal {

/// The faults to inject. Each takes effect in the next call that it concerns; all may be set
/// together.
struct BoardFaults {
  std::uint32_t lose_every = 0;  ///< n: each n-th frame is lost; 1: every frame; 0: none
  bool current_missing = false;  ///< the reading is NaN; likewise the next two
  bool voltage_missing = false;
  bool load_missing = false;
  bool stuck = false;  ///< repeats the readings and the sequence number of the last good frame
  std::int64_t late_ns = 0;  ///< time by which frames come after their time_ns
  bool emergency_stop = false;
  bool driver_fault = false;
  bool drive_dead = false;  ///< drive() and safe_off() do nothing
  bool kick_dead = false;
  bool ends = false;
};

template <Board B>
class FaultyBoard {
 public:
  static constexpr bool in_monotonic_time = requires { requires B::in_monotonic_time; };

  explicit FaultyBoard(B& board) : board_(board) {}

  BoardFaults faults;

  ReadStatus read(Frame& frame) {
    const ReadStatus status = faults.ends ? ReadStatus::end : board_.read(frame);
    if (status == ReadStatus::end) {
      return status;
    }
    const bool lost = faults.lose_every != 0 && ++reads_ % faults.lose_every == 0;
    frame.time_ns += status == ReadStatus::frame ? -faults.late_ns : 0;
    frame.emergency_stop = frame.emergency_stop || faults.emergency_stop;
    frame.driver_fault = frame.driver_fault || faults.driver_fault;
    if (lost || status == ReadStatus::nothing) {
      return ReadStatus::nothing;
    }
    if (faults.stuck && had_frame_) {
      const Frame now = frame;
      frame = last_;
      frame.time_ns = now.time_ns;
      return status;
    }
    spoil(frame);
    last_ = frame;
    had_frame_ = true;
    return status;
  }
  void drive(const DriveCommand& command) {
    if (!faults.drive_dead) {
      board_.drive(command);
    }
  }
  void safe_off() {
    if (!faults.drive_dead) {
      board_.safe_off();
    }
  }
  void kick() {
    if (!faults.kick_dead) {
      board_.kick();
    }
  }
  std::int64_t now_ns() const { return board_.now_ns(); }
  auto off_actions() const
    requires requires(const B& board) { board.off_actions(); }
  {
    return board_.off_actions();
  }

 private:
  void spoil(Frame& frame) const {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    frame.current_A = faults.current_missing ? none : frame.current_A;
    frame.voltage_V = faults.voltage_missing ? none : frame.voltage_V;
    frame.load_N = faults.load_missing ? none : frame.load_N;
  }

  B& board_;
  Frame last_{};
  bool had_frame_ = false;
  std::uint32_t reads_ = 0;
};

}  // namespace smaservo::hal
