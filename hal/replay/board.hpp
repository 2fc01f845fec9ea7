#pragma once
// A board whose measurements come from a recorded trace.

#include <cmath>

#include "hal/board.hpp"
#include "hal/replay/trace.hpp"

namespace smaservo::hal {

class ReplayBoard {
 public:
  /// `load_N` is used if the trace has no load. Throws TraceError if the trace has no time (and the
  /// options give no period), no current or no voltage.
  ReplayBoard(TraceReader trace, double load_N, double area_m2);

  ReadStatus read(Frame& frame);
  void drive(const DriveCommand& command) { last_command_ = command; }
  void safe_off() { last_command_ = {}; }
  void kick() {}
  /// Time of the last row; 0 before the first.
  std::int64_t now_ns() const { return now_ns_; }

  /// The row of the last frame, which also has the references and texts that a frame does not have.
  const TraceRow& row() const { return row_; }
  const TraceReader& trace() const { return trace_; }
  const DriveCommand& last_command() const { return last_command_; }

 private:
  TraceReader trace_;
  double load_N_;
  double area_m2_;
  TraceRow row_{};
  DriveCommand last_command_{};
  std::int64_t now_ns_ = 0;
};

static_assert(Board<ReplayBoard>);

}  // namespace smaservo::hal
