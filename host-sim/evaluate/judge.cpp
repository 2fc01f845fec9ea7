#include "host-sim/evaluate/judge.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace smaservo::evaluate {
namespace {

using Rows = std::span<const JudgedRow>;

constexpr double moving_percent_s = 2;
constexpr double moving_over_s = 0.05;
constexpr double near_for_s = 0.5;
constexpr double at_rest_s = 0.2;
constexpr double locked_for_s = 2;
constexpr double contraction_percent = 20;
constexpr double contracted_percent = 10;
constexpr double sure_after_s = 1;
constexpr double rounding_s = 1e-9;

double error_percent(const JudgedRow& row, double stroke) {
  return 100 * (row.estimate - row.strain) / stroke;
}

/// Rows without an estimate do not count; NaN if there is no other.
double mean_error_percent(Rows run, double stroke, double from_s, double to_s) {
  double sum = 0;
  double count = 0;
  for (const JudgedRow& row : run) {
    if (row.time_s >= from_s - rounding_s && row.time_s < to_s - rounding_s &&
        std::isfinite(row.estimate)) {
      sum += error_percent(row, stroke);
      count += 1;
    }
  }
  return sum / count;
}

bool is_near(const JudgedRow& row, double stroke) {
  return std::abs(error_percent(row, stroke)) <= near_percent;
}

/// The row at which the first half second with a small error begins; run.size() if there is none.
std::size_t first_near(Rows run, double stroke) {
  std::size_t begin = 0;
  for (std::size_t i = 0; i < run.size(); ++i) {
    if (!is_near(run[i], stroke)) {
      begin = i + 1;
    } else if (run[i].time_s - run[begin].time_s >= near_for_s - rounding_s) {
      return begin;
    }
  }
  return run.size();
}

double motion_s(Rows run, double stroke) {
  double moving_s = 0;
  std::size_t past = 0;
  for (std::size_t i = 1; i < run.size(); ++i) {
    while (past + 1 < i && run[i].time_s - run[past + 1].time_s >= moving_over_s - rounding_s) {
      ++past;
    }
    const double percent = 100 * std::abs(run[i].strain - run[past].strain) / stroke;
    const bool moves = percent > moving_percent_s * (run[i].time_s - run[past].time_s);
    moving_s += moves ? run[i].time_s - run[i - 1].time_s : 0;
  }
  return moving_s;
}

/// The time at which the first heating has contracted the wire; the end of the run if there is
/// none.
double heated_s(Rows run, double stroke) {
  const double shortest = std::ranges::min_element(run, {}, &JudgedRow::strain)->strain;
  double longest = shortest;
  for (const JudgedRow& row : run) {
    longest = std::max(longest, row.strain);
    if (100 * (longest - row.strain) >= contraction_percent * stroke &&
        100 * (row.strain - shortest) <= contracted_percent * stroke) {
      return row.time_s;
    }
  }
  return run.back().time_s;
}

}  // namespace

RunFigures judge_errors(Rows run, double stroke, Counted counted) {
  const double zero_percent =
      counted == Counted::displacement
          ? mean_error_percent(run, stroke, run.front().time_s, run.front().time_s + at_rest_s)
          : 0;
  RunFigures figures;
  for (const JudgedRow& row : run) {
    if (row.time_s - run.front().time_s <= settling_s) {
      continue;
    }
    const double percent = error_percent(row, stroke) - zero_percent;
    figures.error.add(percent);
    figures.lost = figures.lost || !(std::abs(percent) <= lost_percent);
    figures.with_sd += std::isnan(row.estimate_sd) ? 0U : 1U;
    figures.within_2_sd += std::abs(row.estimate - row.strain) <= 2 * row.estimate_sd ? 1U : 0U;
  }
  return figures;
}

double hold_drift_percent(Rows run, double stroke, double ripple_begin_s, double ripple_end_s) {
  return mean_error_percent(run, stroke, ripple_end_s - 1, ripple_end_s) -
         mean_error_percent(run, stroke, ripple_begin_s + 1, ripple_begin_s + 2);
}

StartFigures judge_start(Rows run, double stroke) {
  const std::size_t found = first_near(run, stroke);
  const bool never = found == run.size();
  const double end_s = run.back().time_s;
  const bool astray = std::ranges::none_of(run, [&](const JudgedRow& row) {
    return row.time_s >= end_s - locked_for_s && is_near(row, stroke);
  });
  const double asked_s = std::min(heated_s(run, stroke) + sure_after_s, end_s);
  const auto asked = std::ranges::find_if(
      run, [&](const JudgedRow& row) { return row.time_s >= asked_s - rounding_s; });
  return {never ? std::numeric_limits<double>::infinity() : motion_s(run.first(found + 1), stroke),
          never || astray, asked->health == Health::good};
}

}  // namespace smaservo::evaluate
