#pragma once
// CSV files of numbers, compared column by column.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

namespace smaservo::test {

struct NumberTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;  ///< NaN for an empty field

  std::size_t rows() const { return columns.empty() ? 0 : columns.front().size(); }
};

inline NumberTable parse_numbers(const std::string& text) {
  NumberTable table;
  std::istringstream lines(text);
  std::string line;
  while (std::getline(lines, line)) {
    line += ',';
    std::istringstream fields(line);
    std::string field;
    for (std::size_t i = 0; std::getline(fields, field, ','); ++i) {
      if (table.columns.size() <= i) {
        table.columns.emplace_back();
        table.names.push_back(field);
      } else {
        table.columns[i].push_back(field.empty() ? std::numeric_limits<double>::quiet_NaN()
                                                 : std::strtod(field.c_str(), nullptr));
      }
    }
  }
  return table;
}

/// From the smallest to the greatest number of a column.
inline double range(const std::vector<double>& column) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double value : column) {
    low = std::fmin(low, value);
    high = std::fmax(high, value);
  }
  return high > low ? high - low : 0;
}

/// The greatest difference; infinite where only one of the two is a number.
inline double max_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double max = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (std::isnan(a[i]) != std::isnan(b[i])) {
      return std::numeric_limits<double>::infinity();
    }
    max = std::fmax(max, std::abs(a[i] - b[i]));
  }
  return max;
}

}  // namespace smaservo::test
