#include "host-sim/report/thin.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace smaservo::report {
namespace {

using ThinColumns = std::span<const std::vector<double>* const>;

/// Appends the peaks and first gaps of the rows [from, to), in order, each row once.
void append_peaks(ThinColumns columns, std::size_t from, std::size_t to,
                  std::vector<std::size_t>& rows) {
  const auto first = static_cast<std::ptrdiff_t>(rows.size());
  for (const std::vector<double>* column : columns) {
    std::size_t low = to;
    std::size_t high = to;
    std::size_t gap = to;
    for (std::size_t i = from; i < to; ++i) {
      const double value = (*column)[i];
      if (!std::isfinite(value)) {
        gap = std::min(gap, i);
        continue;
      }
      low = low == to || value < (*column)[low] ? i : low;
      high = high == to || value > (*column)[high] ? i : high;
    }
    for (const std::size_t row : {low, high, gap}) {
      if (row != to) {
        rows.push_back(row);
      }
    }
  }
  std::sort(rows.begin() + first, rows.end());
  rows.erase(std::unique(rows.begin() + first, rows.end()), rows.end());
}

}  // namespace

std::vector<std::size_t> rows_to_show(ThinColumns columns, std::size_t max_rows) {
  const std::size_t count = columns.empty() ? 0 : columns.front()->size();
  std::vector<std::size_t> rows(count);
  if (count <= max_rows) {
    std::iota(rows.begin(), rows.end(), 0);
    return rows;
  }
  // A stretch keeps at most three rows of each column, so the loop ends.
  for (std::size_t stretch = 4; rows.size() > max_rows && stretch < 2 * count; stretch *= 2) {
    rows.assign(1, 0);
    for (std::size_t from = 0; from < count; from += stretch) {
      append_peaks(columns, from, std::min(from + stretch, count), rows);
    }
    rows.push_back(count - 1);
    rows.erase(std::ranges::unique(rows).begin(), rows.end());
  }
  return rows;
}

}  // namespace smaservo::report
