#pragma once
// The numbers of the table, with their targets.

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
/// The target of "coarse" is 0.2 above the mean of "standard", if that was evaluated.
std::vector<Figure> row_figures(const ObserverEvaluation& observer, const RowResult& row);

/// Like row_figures() above, for some runs of a row; max_mean is the target of their mean, NaN:
/// none.
std::vector<Figure> row_figures(const EvaluationRow& row, const RowFigures& figures,
                                double max_mean);

const EvaluationRow& row_of(const RowResult& result);

}  // namespace smaservo::evaluate
