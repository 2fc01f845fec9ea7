#pragma once
// What a replay must keep to pass in continuous integration.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/replay/replay.hpp"

namespace smaservo::replay {

/// The greatest error that may be allowed, in per cent of the nominal stroke. A 95 % quantile is
/// known up to 1000 %, so that an estimate that is not a number is above every bound.
inline constexpr double highest_bound_percent = 999;

/// Bounds of a column of the estimate, in the unit of its name. All its values lie between `min`
/// and `max`, and their mean is `mean`, up to `tolerance`.
struct ColumnBounds {
  std::optional<double> min, max, mean;
  double tolerance = 0;
};

/// Bounds of one trace; those that are not given allow everything.
struct Bounds {
  std::string given_by;  ///< the option or the table of the file that has them, for messages
  std::string observer;  ///< whose errors are judged; empty: the first one's, which writes the
                         ///< estimate
  std::optional<double> mean_percent, p95_percent, max_percent;
  std::optional<std::uint64_t> rows;  ///< exactly so many
  std::optional<std::uint64_t> max_skipped, max_invalid;
  std::array<std::optional<ColumnBounds>, summarized_columns.size()> columns;

  bool of_errors() const { return mean_percent || p95_percent || max_percent; }
};

/// The bounds of --fail-above, as "mean=1,p95=3,max=10". Throws UserError.
Bounds parse_fail_above(std::string_view text);

/// A line for each bound that the result does not keep, as "kalman: mean error is 1.42 %, allowed
/// is 1 %". A value that equals its bound keeps it. Throws UserError where a bound cannot be
/// judged: without a reference, or if its observer did not run.
std::vector<std::string> misses(const Bounds& bounds, const ReplayResult& result);

}  // namespace smaservo::replay
