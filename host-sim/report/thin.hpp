#pragma once
// Thins long columns to few rows without losing a peak.

#include <cstddef>
#include <span>
#include <vector>

namespace smaservo::report {

/// The rows to show of columns of equal length: all if there are no more than `max_rows`; otherwise
/// in each stretch of rows those in which a column has its smallest, its greatest or its first
/// value that is not finite, which leaves a gap; and the first and the last row of all. Stretches
/// are as short as the bound allows. Cost: about ten passes over the columns.
std::vector<std::size_t> rows_to_show(std::span<const std::vector<double>* const> columns,
                                      std::size_t max_rows);

}  // namespace smaservo::report
