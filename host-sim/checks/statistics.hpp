#pragma once
// Statistics of columns for the checks of a record; NaN is a reading that was not taken.

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <vector>

namespace smaservo::checks {

using Values = std::vector<double>;

/// Values of NiTi; only the order of magnitude matters.
inline constexpr double density_kg_m3 = 6450, specific_heat_J_kgK = 450;

inline Values known(const Values& values) {
  Values some;
  std::ranges::copy_if(values, std::back_inserter(some), [](double v) { return !std::isnan(v); });
  return some;
}

/// NaN if nothing is known.
inline double median(const Values& values) {
  Values some = known(values);
  if (some.empty()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const auto at = some.begin() + static_cast<std::ptrdiff_t>(some.size() / 2);
  std::ranges::nth_element(some, at);
  return *at;
}

/// The range without the lowest and the highest hundredth, so that a few outliers do not count as
/// motion.
struct Range {
  double low, middle, high;
};
inline Range range_of(const Values& values) {
  Values sorted = known(values);
  if (sorted.empty()) {
    return {0, 0, 0};
  }
  std::ranges::sort(sorted);
  const std::size_t outer = sorted.size() / 100;
  return {sorted[outer], sorted[sorted.size() / 2], sorted[sorted.size() - 1 - outer]};
}

inline double span_of(std::span<const double> values) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double value : values) {
    if (!std::isnan(value)) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  return std::max(high - low, 0.0);
}

/// The finest step of the column, due to its converter or to the digits in which it was written;
/// infinite where all values are the same.
inline double step_of(const Values& values) {
  Values sorted = known(values);
  double step = std::numeric_limits<double>::infinity();
  if (sorted.empty()) {
    return step;
  }
  std::ranges::sort(sorted);
  const double min = 1e-9 * (sorted.back() - sorted.front());
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i] - sorted[i - 1] > min) {
      step = std::min(step, sorted[i] - sorted[i - 1]);
    }
  }
  return step;
}

}  // namespace smaservo::checks
