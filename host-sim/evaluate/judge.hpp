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
  double estimate, estimate_sd;  ///< the deviation is NaN if an observer has none
  Health health;
};

inline constexpr double settling_s = 1;     ///< errors count after this time
inline constexpr double lost_percent = 20;  ///< a run with a greater error after settling_s is lost
/// Error below which an observer has found the strain from an unknown start.
inline constexpr double near_percent = 6;

/// What counts as an error.
enum class Counted : unsigned char {
  strain,  ///< the error of the strain, that is, of the wire's length
  /// The same less its mean over the first 0.2 s, in which the cold wire rests: the error of the
  /// displacement from there, as of a servo that takes the cold wire as its zero.
  displacement,
};

/// Errors are in per cent of the nominal stroke.
struct RunFigures {
  replay::ErrorStatistics error;  ///< errors after the first second
  std::uint64_t with_sd = 0;      ///< number of errors with a reported standard deviation
  /// Number of those errors that are within two deviations; always of the strain.
  std::uint64_t within_2_sd = 0;
  bool lost = false;
};
RunFigures judge_errors(std::span<const JudgedRow> run, double stroke,
                        Counted counted = Counted::strain);

/// The change of the error while the wire was held: its mean over the last second of the ripple
/// less its mean over the second second, in % of the stroke, signed. The first second does not
/// count, because the wire settles into the loop of the ripple.
double hold_drift_percent(std::span<const JudgedRow> run, double stroke, double ripple_begin_s,
                          double ripple_end_s);

/// The figures of a start in the middle of a motion.
struct StartFigures {
  /// Time of motion before the first half second throughout which the error is within 6 %; infinite
  /// if there is none. The wire is in motion when its strain changes by more than 2 % of the stroke
  /// per second: a wire at rest gives an observer no information.
  double found_after_s;
  /// The strain was never found, or the error is above 6 % throughout the last two seconds.
  bool locked;
  /// The health is good one second after the first heating. That has ended when the wire has
  /// contracted by at least 20 % of the stroke and is within 10 % of its shortest length.
  bool sure;
};
StartFigures judge_start(std::span<const JudgedRow> run, double stroke);

}  // namespace smaservo::evaluate
