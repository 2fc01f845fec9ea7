#include "host-sim/report/text_plot.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <span>

namespace smaservo::report {
namespace {

constexpr std::size_t label_width = 10;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<double> columns_of(std::span<const double> values, std::size_t width) {
  const std::size_t count = std::min(values.size(), width);
  std::vector<double> columns;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t from = i * values.size() / count;
    const std::size_t to = (i + 1) * values.size() / count;
    double sum = 0;
    int used = 0;
    for (const double value : values.subspan(from, to - from)) {
      if (std::isfinite(value)) {
        sum += value;
        ++used;
      }
    }
    columns.push_back(used > 0 ? sum / used : nan);
  }
  return columns;
}

/// A number with as many of six digits as the width has room for.
std::string label_text(double value, std::size_t width) {
  std::string text;
  for (int digits = 6; digits > 0; --digits) {
    text = fmt::format("{:.{}g}", value, digits);
    if (text.size() <= width) {
      break;
    }
  }
  return text;
}

}  // namespace

std::string text_plot(const std::vector<std::vector<double>>& curves, std::size_t width,
                      std::size_t height) {
  std::vector<std::vector<double>> drawn;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const std::vector<double>& curve : curves) {
    drawn.push_back(columns_of(curve, width));
    for (const double value : drawn.back()) {
      if (std::isfinite(value)) {
        low = std::min(low, value);
        high = std::max(high, value);
      }
    }
  }
  if (!(low <= high)) {
    return "";
  }
  const double span = high > low ? high - low : 1;
  std::vector<std::string> rows(height, std::string(width, ' '));
  for (std::size_t curve = drawn.size(); curve-- > 0;) {
    const std::vector<double>& columns = drawn[curve];
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (!std::isfinite(columns[i])) {
        continue;
      }
      const double share = (columns[i] - low) / span;
      const auto up =
          static_cast<std::size_t>(std::lround(share * static_cast<double>(height - 1)));
      rows[height - 1 - up][i] = curve == 0 ? '*' : '.';
    }
  }
  std::string text;
  for (std::size_t i = 0; i < height; ++i) {
    const std::string label = i == 0            ? label_text(high, label_width)
                              : i + 1 == height ? label_text(low, label_width)
                                                : "";
    rows[i].erase(rows[i].find_last_not_of(' ') + 1);
    text += fmt::format("{:>{}} |{}\n", label, label_width, rows[i]);
  }
  return text;
}

}  // namespace smaservo::report
