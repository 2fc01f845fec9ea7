#pragma once
// The figures of an observer in one run.

#include <cstdint>
#include <span>
#include <vector>

#include "host-sim/replay/error_statistics.hpp"
#include "observer/estimate.hpp"

namespace smaservo::evaluate {

/// The truth and the estimate at one instant.
struct JudgedRow {
  double time_s;
  double strain;
  double estimate, estimate_sd;  ///< the deviation is NaN where an observer has none
  Health health;
};

inline constexpr double settling_s = 1;     ///< errors count after this time
inline constexpr double lost_percent = 20;  ///< a run with a greater error after that time is lost
inline constexpr double near_percent =
    6;  ///< error below which an observer has found the strain from an unknown start

/// Errors are in per cent of the nominal stroke.
struct RunFigures {
  replay::ErrorStatistics error;  ///< after the first second
  std::uint64_t with_sd = 0;      ///< number of errors with a reported standard deviation
  std::uint64_t within_2_sd = 0;  ///< number of those errors inside of two deviations
  bool lost = false;
};
RunFigures judge_errors(std::span<const JudgedRow> run, double stroke);

/// How the error moved while the wire was held: its mean over the last second of the ripple less
/// that over the second second, in % of the stroke with its sign. The first second does not count:
/// the wire settles into the loop that the ripple makes.
double hold_drift_percent(std::span<const JudgedRow> run, double stroke, double ripple_begin_s,
                          double ripple_end_s);

/// The figures of a start in the middle of a motion.
struct StartFigures {
  /// Time of motion before the first half second in which the error is within 6 % throughout;
  /// infinite when there is none. The wire moves when its strain changes by more than 2 % of the
  /// stroke per second: a wire at rest tells an observer nothing.
  double found_after_s;
  /// It was never found, or the error is above 6 % throughout the last two seconds.
  bool locked;
  /// The health is good one second after the first heating, which has ended when the wire has
  /// contracted by 20 % of the stroke or more and is within 10 % of its shortest.
  bool sure;
};
StartFigures judge_start(std::span<const JudgedRow> run, double stroke);

}  // namespace smaservo::evaluate
