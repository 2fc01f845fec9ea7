#pragma once
// A board whose measurements come from a recorded trace.

#include <cmath>

#include "hal/board.hpp"
#include "hal/replay/trace.hpp"

namespace smaservo::hal {

/// A board that reads the rows of a recording; what it is commanded is only kept.
class ReplayBoard {
 public:
  /// `load_N` is used if the trace has no load. Throws TraceError if the trace has no time (and the
  /// options give no period), no current or no voltage.
  ReplayBoard(TraceReader trace, double load_N, double area_m2);

  /// The next row. A row of a device's log that had no fresh frame is ReadStatus::nothing. Throws
  /// TraceError for a bad row.
  ReadStatus read(Frame& frame);
  /// Keeps the command.
  void drive(const DriveCommand& command) { last_command_ = command; }
  /// Keeps a command of no current.
  void safe_off() { last_command_ = {}; }
  /// Does nothing.
  void kick() {}
  /// Time of the last row; 0 before the first.
  std::int64_t now_ns() const { return now_ns_; }

  /// The row of the last frame, which also has the references and texts that a frame does not have.
  const TraceRow& row() const { return row_; }
  /// The recording.
  const TraceReader& trace() const { return trace_; }
  /// The command of the last drive().
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
