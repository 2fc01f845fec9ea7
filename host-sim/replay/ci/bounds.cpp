#include "host-sim/replay/ci/bounds.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "model/files/error.hpp"

namespace smaservo::replay {
namespace {

struct ErrorBound {
  std::string_view key;
  std::string_view words;
  std::optional<double> Bounds::* bound;
  double (*value)(const ErrorStatistics& error);
};

constexpr std::array<ErrorBound, 3> error_bounds{{
    {"mean", "mean error", &Bounds::mean_percent, [](const auto& e) { return e.mean(); }},
    {"p95", "95 % quantile of the error", &Bounds::p95_percent,
     [](const auto& e) { return e.quantile(0.95); }},
    {"max", "maximum error", &Bounds::max_percent, [](const auto& e) { return e.maximum(); }},
}};

/// Quantiles are sums of steps of 0.01 %, and differ from the written number in the last bit.
constexpr double rounding_percent = 1e-9;

[[noreturn]] void refuse(std::string_view item, const std::string& reason) {
  throw files::UserError(fmt::format("--fail-above {}: {}", item, reason));
}

double bound_of(std::string_view item, std::string_view text) {
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = failure == std::errc{} && end == text.data() + text.size();
  if (!whole || !(value >= 0 && value <= highest_bound_percent)) {
    refuse(item, fmt::format("must be a number between 0 and {:g}, in % of the nominal stroke",
                             highest_bound_percent));
  }
  return value;
}

/// Both numbers with so many digits that they differ.
std::string is_above(double value, double allowed) {
  for (int digits = 3; digits < 17; ++digits) {
    const std::string is = fmt::format("{:.{}g}", value, digits);
    if (is != fmt::format("{:.{}g}", allowed, digits)) {
      return fmt::format("is {} %, allowed is {:g} %", is, allowed);
    }
  }
  return fmt::format("is {} %, allowed is {} %", value, allowed);
}

/// Only the resistance may be missing in a row: where the current is too small to measure it.
constexpr std::string_view may_be_empty = "resistance_ohm";

void judge_column(std::string_view name, const ColumnBounds& bounds, const ColumnSummary& column,
                  std::vector<std::string>& missed) {
  if (column.count == 0 || (column.empty > 0 && name != may_be_empty)) {
    missed.push_back(fmt::format("{} is not a number in {} rows", name, column.empty));
  }
  if (column.count == 0) {
    return;
  }
  if (bounds.min && !(column.min >= *bounds.min)) {
    missed.push_back(
        fmt::format("the least {} is {:.6g}, allowed is {:g}", name, column.min, *bounds.min));
  }
  if (bounds.max && !(column.max <= *bounds.max)) {
    missed.push_back(
        fmt::format("the greatest {} is {:.6g}, allowed is {:g}", name, column.max, *bounds.max));
  }
  if (bounds.mean && !(std::abs(column.mean() - *bounds.mean) <= bounds.tolerance)) {
    missed.push_back(fmt::format("the mean {} is {:.6g}, allowed is {:g} +- {:g}", name,
                                 column.mean(), *bounds.mean, bounds.tolerance));
  }
}

const ObserverResult& judged_observer(const Bounds& bounds, const ReplayResult& result) {
  if (bounds.observer.empty()) {
    return result.observers.front();
  }
  const auto found = std::ranges::find(result.observers, bounds.observer, &ObserverResult::name);
  if (found == result.observers.end()) {
    throw files::UserError(fmt::format(
        "{}: the observer {} has not run{}", bounds.given_by, bounds.observer,
        result.open_loop ? "; temperature and stress are given, so the model runs alone" : ""));
  }
  return *found;
}

void judge_errors(const Bounds& bounds, const ReplayResult& result,
                  std::vector<std::string>& missed) {
  if (!result.has_reference) {
    throw files::UserError(fmt::format(
        "{}: no error can be judged, since the trace has neither strain_ref nor a displacement",
        bounds.given_by));
  }
  const ObserverResult& observer = judged_observer(bounds, result);
  if (observer.error.count() == 0) {
    throw files::UserError(fmt::format(
        "{}: no error can be judged, since the reference is empty in every row", bounds.given_by));
  }
  for (const ErrorBound& b : error_bounds) {
    const std::optional<double>& allowed = bounds.*b.bound;
    const double value = b.value(observer.error);
    if (allowed && !(value <= *allowed + rounding_percent)) {
      missed.push_back(fmt::format("{}: {} {}", observer.name, b.words, is_above(value, *allowed)));
    }
  }
}

}  // namespace

Bounds parse_fail_above(std::string_view text) {
  Bounds bounds;
  bounds.given_by = "--fail-above";
  while (true) {
    const std::string_view item = text.substr(0, text.find(','));
    const std::string_view key = item.substr(0, item.find('='));
    const auto* const found = std::ranges::find(error_bounds, key, &ErrorBound::key);
    if (found == error_bounds.end() || key.size() == item.size()) {
      refuse(item.empty() ? "''" : item,
             "must be mean=, p95= or max= with a number in % of the "
             "nominal stroke, as mean=1,p95=3,max=10");
    }
    std::optional<double>& bound = bounds.*found->bound;
    if (bound) {
      refuse(item, fmt::format("{} is given twice", key));
    }
    bound = bound_of(item, item.substr(key.size() + 1));
    if (item.size() == text.size()) {
      return bounds;
    }
    text.remove_prefix(item.size() + 1);
  }
}

std::vector<std::string> misses(const Bounds& bounds, const ReplayResult& result) {
  std::vector<std::string> missed;
  if (bounds.rows && result.rows != *bounds.rows) {
    missed.push_back(fmt::format("has {} rows, expected are {}", result.rows, *bounds.rows));
  }
  if (bounds.max_skipped && result.skipped > *bounds.max_skipped) {
    missed.push_back(
        fmt::format("{} rows were skipped, allowed are {}", result.skipped, *bounds.max_skipped));
  }
  if (bounds.max_invalid && result.invalid > *bounds.max_invalid) {
    missed.push_back(fmt::format("{} rows have no valid resistance, allowed are {}", result.invalid,
                                 *bounds.max_invalid));
  }
  for (std::size_t i = 0; i < bounds.columns.size(); ++i) {
    if (const std::optional<ColumnBounds>& column = bounds.columns[i]) {
      judge_column(summarized_columns[i], *column, result.columns[i], missed);
    }
  }
  if (bounds.of_errors()) {
    judge_errors(bounds, result, missed);
  }
  return missed;
}

}  // namespace smaservo::replay
