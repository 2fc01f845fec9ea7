#include "hal/replay/board.hpp"

#include <utility>

namespace smaservo {

ReplayBoard::ReplayBoard(TraceReader trace, double load_N, double area_m2)
    : trace_(std::move(trace)), load_N_(load_N), area_m2_(area_m2) {
  if (!trace_.timed() || !trace_.has(Column::current) || !trace_.has(Column::voltage)) {
    throw TraceError("a trace for the board needs time, current and voltage");
  }
}

ReadStatus ReplayBoard::read(Frame& frame) {
  if (!trace_.next(row_)) {
    return ReadStatus::end;
  }
  double load_N = load_N_;
  if (trace_.has(Column::load)) {
    load_N = row_[Column::load];
  } else if (trace_.has(Column::stress)) {
    load_N = row_[Column::stress] * area_m2_;
  }
  // A row that was skipped is a lost frame.
  const auto sequence = static_cast<std::uint32_t>(trace_.rows() + trace_.skipped() - 1);
  frame = {static_cast<std::int64_t>(std::llround(row_[Column::time] * 1e9)), sequence,
           row_[Column::current], row_[Column::voltage], load_N};
  return ReadStatus::frame;
}

}  // namespace smaservo
