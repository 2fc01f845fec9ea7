#include "host-sim/commission/anchor.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <utility>

#include "hal/replay/trace.hpp"
#include "host-sim/how_read.hpp"
#include "model/files/error.hpp"

namespace smaservo::commission {
namespace {

constexpr double metres_per_mm = 1e-3;

[[noreturn]] void refuse(std::string_view text, std::string_view what) {
  throw files::UserError(fmt::format(
      "--anchor {}: {}; it is TIME_S,DISPLACEMENT_MM or TIME_S,DISPLACEMENT_MM,SD_MM, such as "
      "12.5,3.42 or 12.5,3.42,0.02",
      text, what));
}

/// With rounding of numbers in mm.
bool is_deviation(double sd_m) {
  return 0.999e-6 < sd_m && sd_m < 1.001;
}

std::optional<double> finite_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good = error == std::errc() && end == text.data() + text.size();
  return good && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

double number_of(std::string_view part, std::string_view whole) {
  const std::optional<double> value = finite_number(part);
  if (!value) {
    refuse(whole, fmt::format("'{}' is not a finite number", part));
  }
  return *value;
}

/// The column of the readings' own deviations, and metres in its unit; column == names.size():
/// none.
struct DeviationColumn {
  std::size_t column;
  double metres;
};
DeviationColumn deviation_column(const std::string& path, const std::vector<std::string>& names) {
  constexpr std::pair<std::string_view, double> known[] = {{"sd_mm", metres_per_mm}, {"sd_m", 1}};
  for (const auto& [name, metres] : known) {
    const auto at = std::ranges::find(names, name);
    if (at != names.end()) {
      return {static_cast<std::size_t>(at - names.begin()), metres};
    }
  }
  const auto other =
      std::ranges::find_if(names, [](const std::string& name) { return name.starts_with("sd"); });
  if (other != names.end()) {
    throw files::UserError(
        fmt::format("{}: column '{}': the deviation of a reading is sd_mm or sd_m", path, *other));
  }
  return {names.size(), 1};
}

/// A field of a row as CSV.
std::string_view field(std::string_view row, std::size_t column) {
  for (; column > 0; --column) {
    row.remove_prefix(std::min(row.find(',') + 1, row.size()));
  }
  return row.substr(0, row.find(','));
}

std::vector<Anchor> read_columns(const std::string& path, double sd_m) {
  hal::TraceReader trace(path, {});
  say_how_read(path, trace);
  if (!trace.timed() || !trace.has(hal::Column::displacement)) {
    throw files::UserError(fmt::format(
        "{}: a file of readings needs the columns time_s and displacement_mm; it has no {}", path,
        trace.timed() ? "displacement" : "time"));
  }
  const DeviationColumn own = deviation_column(path, trace.names());
  std::vector<Anchor> anchors;
  hal::TraceRow row{};
  while (trace.next(row)) {
    Anchor anchor{row[hal::Column::time], row[hal::Column::displacement], sd_m};
    if (std::isnan(anchor.displacement_m)) {
      continue;
    }
    if (own.column < trace.names().size()) {
      const std::string_view text = field(row.text, own.column);
      anchor.sd_m = own.metres * finite_number(text).value_or(0);
      if (!is_deviation(anchor.sd_m)) {
        throw files::UserError(fmt::format("{}: {} {}: the deviation '{}' must be 0.001 to 1000 mm",
                                           path, trace.word(), row.line, text));
      }
    }
    anchors.push_back(anchor);
  }
  return anchors;
}

}  // namespace

Anchor parse_anchor(std::string_view text, double sd_m) {
  std::vector<double> numbers;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    numbers.push_back(number_of(text.substr(from, comma - from), text));
    from = comma + 1;
  }
  if (numbers.size() < 2 || numbers.size() > 3) {
    refuse(text, fmt::format("has {} number{}", numbers.size(), numbers.size() == 1 ? "" : "s"));
  }
  if (numbers.size() == 3 && !is_deviation(metres_per_mm * numbers[2])) {
    refuse(text, "the standard deviation must be 0.001 to 1000 mm");
  }
  return {numbers[0], metres_per_mm * numbers[1],
          numbers.size() == 3 ? metres_per_mm * numbers[2] : sd_m};
}

std::vector<Anchor> read_anchors(const std::string& path, double sd_m) {
  try {
    return read_columns(path, sd_m);
  } catch (const hal::TraceError& error) {
    throw files::UserError(fmt::format(
        "{}. A file of readings has the columns time_s and displacement_mm, by these names "
        "(--column is for RUN), and rises in time",
        error.what()));
  }
}

}  // namespace smaservo::commission
