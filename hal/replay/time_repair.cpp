#include "hal/replay/time_repair.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace smaservo::hal {

double wrap_s(double last_s, double next_s, double step_s) {
  for (const double period_s : {4294.967296, 4294967.296, 65.536}) {
    const double gap_s = next_s + period_s - last_s;
    if (gap_s > 0 && gap_s < 10 * step_s) {
      return period_s;
    }
  }
  return 0;
}

/// Whether the first row is late or the second one is early; otherwise the first one can be given.
TimeRepair::Verdict TimeRepair::judge() const {
  if (rows_.size() < 2 || raw_s(1) > raw_s(0)) {
    return Verdict::rises;
  }
  const bool begins = !(raw_s(0) > last_raw_s_);
  const bool second_follows = begins || raw_s(1) > last_raw_s_;
  const bool third_is_there = rows_.size() >= judged_with;
  if (third_is_there && raw_s(2) > raw_s(0)) {
    return Verdict::early;
  }
  if (second_follows) {
    return Verdict::late;
  }
  // The clock fell back permanently if it rises from there.
  return third_is_there && raw_s(2) > raw_s(1) ? Verdict::rises : Verdict::early;
}

TimeRepair::Verdict TimeRepair::place(TraceRow& row) {
  double& time_s = row.values[static_cast<std::size_t>(Column::time)];
  const double raw_s = time_s;
  Verdict verdict = Verdict::rises;
  if (!(raw_s > last_raw_s_)) {
    const double period_s = wrap_s(last_raw_s_, raw_s, step_s_);
    if (period_s > 0) {
      offset_s_ += period_s;
      verdict = Verdict::wraps;
    } else {
      offset_s_ = last_s_ + step_s_ - raw_s;
      ++piece_;
      verdict = Verdict::begins;
    }
  }
  time_s = std::max(raw_s + offset_s_, std::nextafter(last_s_, std::numeric_limits<double>::max()));
  if (std::isfinite(last_s_)) {
    step_s_ = time_s - last_s_;
  }
  last_raw_s_ = raw_s;
  last_s_ = time_s;
  row.piece = piece_;
  return verdict;
}

TimeRepair::Taken TimeRepair::take(WaitingRow& row) {
  const Verdict verdict = judge();
  const std::size_t at = verdict == Verdict::early ? 1 : 0;
  Taken taken{verdict, raw_s(at), at == 1 ? raw_s(0) : last_raw_s_};
  if (verdict == Verdict::late) {
    taken.other_s = raw_s(1);
  }
  const auto from = rows_.begin() + static_cast<std::ptrdiff_t>(at);
  row = std::move(*from);
  rows_.erase(from);
  if (verdict == Verdict::rises) {
    taken.verdict = place(row.row);
  }
  return taken;
}

}  // namespace smaservo::hal
