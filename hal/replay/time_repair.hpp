#pragma once
// What a lenient reader makes of times that do not rise: one that is odd costs its row, a clock
// that wraps is unwrapped, and a clock that began anew begins a new piece, whose times go on after
// the last one's.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <string>

#include "hal/replay/trace.hpp"

namespace smaservo::hal {

/// A row that waits until the times after it are known.
struct WaitingRow {
  TraceRow row;
  std::string text;  ///< of the row, which row.text does not point to
  std::uint64_t line;
};

class TimeRepair {
 public:
  /// Rows that have to wait for the first of them to be judged, where the trace has as many.
  static constexpr std::size_t judged_with = 3;

  enum class Verdict : unsigned char {
    rises,   ///< the first row's time comes after the one before
    early,   ///< the row does not come after the one before, and those behind it do
    late,    ///< the row comes after all those behind it
    wraps,   ///< the counter of a logger began at 0 again; its time is known
    begins,  ///< the clock began anew: a new piece
  };

  struct Taken {
    Verdict verdict;
    double read_s;   ///< the row's time, as it was read
    double other_s;  ///< the same of the row before; where it is late, of the next one
  };

  void add(WaitingRow row) { rows_.push_back(std::move(row)); }
  std::size_t waiting() const { return rows_.size(); }

  /// Takes a row: the first one, whose time and piece it sets, or one that is early or late. There
  /// must be one.
  Taken take(WaitingRow& row);

 private:
  double raw_s(std::size_t i) const { return rows_[i].row[Column::time]; }
  Verdict judge() const;
  Verdict place(TraceRow& row);

  std::deque<WaitingRow> rows_;
  double last_raw_s_ = -std::numeric_limits<double>::infinity();  ///< of the last row, as read
  double last_s_ = last_raw_s_;                                   ///< the same as it was given
  double step_s_ = 1e-3;                                          ///< between the last two
  double offset_s_ = 0;
  std::uint32_t piece_ = 0;
};

}  // namespace smaservo::hal
