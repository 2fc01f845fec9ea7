#pragma once
// The numbers of the table, with their targets.

#include <optional>
#include <string_view>
#include <vector>

#include "host-sim/evaluate/evaluate.hpp"

namespace smaservo::evaluate {

/// A number of a row, and its target.
struct Figure {
  std::string_view name;
  double value;
  double min, max;  ///< the target; NaN if there is none

  bool has_target() const;
  bool missed() const;  ///< a NaN misses every target
};

/// All figures of a row with their targets: "mean_percent", "p95_percent", "max_percent", "lost",
/// "within_2_sd_percent", and, in the rows that have them, "drift_mean_percent",
/// "drift_p95_percent", "drift_max_percent", "found_median_s", "found_p90_s", "locked", "unsure".
/// They are those of all runs, or with `family` those of its runs. Both have the same targets, but
/// in "coarse": its mean may be 0.2 above that of the same runs' "standard", if that was evaluated.
/// Without runs all are NaN, and have no target.
std::vector<Figure> row_figures(const ObserverEvaluation& observer, const RowResult& result,
                                std::optional<hal::Family> family = {});

/// The runs whose figures row_figures() has.
const RowFigures& runs_of(const RowResult& result, std::optional<hal::Family> family);

const EvaluationRow& row_of(const RowResult& result);

}  // namespace smaservo::evaluate
