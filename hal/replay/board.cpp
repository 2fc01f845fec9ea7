#include "hal/replay/board.hpp"

#include <utility>

namespace smaservo::hal {

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
  now_ns_ = row_.time_ns();
  frame.time_ns = now_ns_;
  if (trace_.has(Column::fresh) && row_[Column::fresh] == 0) {
    return ReadStatus::nothing;
  }
  double load_N = load_N_;
  if (trace_.has(Column::load)) {
    load_N = row_[Column::load];
  } else if (trace_.has(Column::stress)) {
    load_N = row_[Column::stress] * area_m2_;
  }
  // A skipped row counts as a lost frame.
  const auto sequence =
      trace_.has(Column::sequence) ? row_[Column::sequence] : static_cast<double>(row_.number);
  frame = {.time_ns = now_ns_,
           .sequence = static_cast<std::uint32_t>(sequence),
           .current_A = row_[Column::current],
           .voltage_V = row_[Column::voltage],
           .load_N = load_N,
           .supply_V = row_[Column::supply],
           .ambient_K = row_[Column::ambient],
           .driver_K = row_[Column::driver],
           .emergency_stop = row_[Column::emergency_stop] > 0,
           .driver_fault = row_[Column::driver_fault] > 0};
  return ReadStatus::frame;
}

}  // namespace smaservo::hal
