#pragma once
// How a lenient reader treats times that do not rise: a row with an outlying time is dropped; a
// clock that wraps is unwrapped; a clock that restarts begins a new piece, whose times continue
// after those of the piece before.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <string>

#include "hal/replay/trace.hpp"

namespace smaservo::hal {

/// The period of a wrapping counter of a logger (micros() and millis() of 32 bits, milliseconds of
/// 16 bits) for which `next_s` comes soon after `last_s`, within ten steps; 0 if there is none.
double wrap_s(double last_s, double next_s, double step_s);

/// A row that waits until the times after it are known.
struct WaitingRow {
  TraceRow row;
  std::string text;  ///< text of the row; row.text does not point to it
  std::uint64_t line;
};

class TimeRepair {
 public:
  /// Number of rows that must be known to judge the first of them, if the trace has as many.
  static constexpr std::size_t judged_with = 3;

  enum class Verdict : unsigned char {
    rises,   ///< the first row's time comes after that of the row before
    early,   ///< the row does not come after the row before, but the rows behind it do
    late,    ///< the row's time is later than those of all rows behind it
    wraps,   ///< the counter of a logger wrapped to 0; the time is known
    begins,  ///< the clock restarted: a new piece
  };

  struct Taken {
    Verdict verdict;
    double read_s;   ///< the row's time as read
    double other_s;  ///< as read: time of the row before; for a late row, of the next one
  };

  void add(WaitingRow row) { rows_.push_back(std::move(row)); }
  std::size_t waiting() const { return rows_.size(); }

  /// Takes out a row: the first one, whose time and piece it sets, or one that is early or late.
  /// There must be a row.
  Taken take(WaitingRow& row);

 private:
  double raw_s(std::size_t i) const { return rows_[i].row[Column::time]; }
  Verdict judge() const;
  Verdict place(TraceRow& row);

  std::deque<WaitingRow> rows_;
  double last_raw_s_ = -std::numeric_limits<double>::infinity();  ///< time of the last row as read
  double last_s_ = last_raw_s_;                                   ///< time of the last row as given
  double step_s_ = 1e-3;  ///< time between the last two rows
  double offset_s_ = 0;
  std::uint32_t piece_ = 0;
};

}  // namespace smaservo::hal
