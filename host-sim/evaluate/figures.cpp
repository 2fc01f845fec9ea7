#include "host-sim/evaluate/figures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace smaservo::evaluate {
namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
constexpr double coarse_allowance_percent = 0.2;

/// The target of the mean error; NaN if there is none.
double max_mean(const ObserverEvaluation& observer, const RowResult& result,
                std::optional<hal::Family> family) {
  if (std::ranges::count(row_of(result).conditions, Condition::coarse) == 0) {
    return row_of(result).mean;
  }
  const auto standard = std::ranges::find_if(
      observer.rows, [](const RowResult& other) { return row_of(other).name == "standard"; });
  return standard == observer.rows.end()
             ? undefined
             : runs_of(*standard, family).error.mean() + coarse_allowance_percent;
}

}  // namespace

const EvaluationRow& row_of(const RowResult& result) {
  return evaluation_rows().at(result.row);
}

const RowFigures& runs_of(const RowResult& result, std::optional<hal::Family> family) {
  if (!family) {
    return result.all;
  }
  return std::ranges::find(result.by_family, *family, &FamilyFigures::family)->figures;
}

std::vector<Figure> row_figures(const ObserverEvaluation& observer, const RowResult& result,
                                std::optional<hal::Family> family) {
  const EvaluationRow& row = row_of(result);
  const RowFigures& f = runs_of(result, family);
  const bool limited = !std::isnan(row.maximum);
  std::vector<Figure> all{
      {"mean_percent", f.error.mean(), undefined, max_mean(observer, result, family)},
      {"p95_percent", f.error.quantile(0.95), undefined, row.p95},
      {"max_percent", f.error.maximum(), undefined, row.maximum},
      {"lost", static_cast<double>(f.lost), undefined, limited ? 0 : undefined},
      {"within_2_sd_percent", 100 * f.within_2_sd, 92, 98}};
  if (std::isnan(f.within_2_sd)) {
    all.back().min = all.back().max = undefined;
  }
  const auto has = [&](Condition condition) {
    return std::ranges::count(row.conditions, condition) > 0;
  };
  if (has(Condition::hold_ripple)) {
    all.push_back({"drift_mean_percent", f.drift_mean, undefined, undefined});
    all.push_back({"drift_p95_percent", f.drift_p95, undefined, 0.4});
    all.push_back({"drift_max_percent", f.drift_maximum, undefined, undefined});
  }
  if (has(Condition::unknown_start)) {
    all.push_back({"found_median_s", f.found_median_s, undefined, undefined});
    all.push_back({"found_p90_s", f.found_p90_s, undefined, 0.2});
    all.push_back({"locked", static_cast<double>(f.locked), undefined, 0});
    all.push_back({"unsure", static_cast<double>(f.unsure), undefined, 0});
  }
  if (f.runs == 0) {
    for (Figure& figure : all) {
      figure.value = figure.min = figure.max = undefined;
    }
  }
  return all;
}

bool Figure::has_target() const {
  return !std::isnan(max);
}

bool Figure::missed() const {
  return has_target() && !(value <= max && (std::isnan(min) || value >= min));
}

}  // namespace smaservo::evaluate
