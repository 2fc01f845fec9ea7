#include "host-sim/can/bus/recording.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <limits>
#include <sstream>

#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::can {
namespace {

/// The device sends floats, and to_csv() writes them.
constexpr auto max_number = static_cast<double>(std::numeric_limits<float>::max());

/// Relative tolerance of the period, because times are written with nine digits.
constexpr double period_tolerance = 0.01;

/// The number in a field. An empty field is NaN; otherwise the whole text must be a number.
double field_number(const std::string& text, const std::string& path, unsigned line) {
  if (text.empty()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool fits = std::abs(number) <= max_number;
  if (error != std::errc{} || end != text.data() + text.size() || !fits) {
    throw files::UserError(
        fmt::format("{}:{}: {}: is not a number of at most {:.2g}", path, line, text, max_number));
  }
  return number;
}

/// Takes the time of a row, which must be one period after that of the row before; the first two
/// rows define the period.
void take_time(double time_s, Recording& recording, double& last_s, const std::string& where) {
  const std::size_t rows = recording.rows.size();
  const double step_s = time_s - last_s;
  last_s = time_s;
  if (rows == 1) {
    recording.period_s = step_s;
  }
  if (std::isnan(time_s) || (rows > 0 && !(step_s > 0))) {
    throw files::UserError(fmt::format("{}: time_s must increase", where));
  }
  if (rows > 1 && std::abs(step_s - recording.period_s) > period_tolerance * recording.period_s) {
    throw files::UserError(fmt::format(
        "{}: time_s is {:.9g} s later than before, must be {:.9g} s as in the first rows", where,
        step_s, recording.period_s));
  }
}

}  // namespace

std::vector<double> Recording::column(const std::string& signal) const {
  const auto found = std::ranges::find(signals, signal);
  if (found == signals.end()) {
    throw files::UserError(fmt::format("{} was not recorded", signal));
  }
  const auto at = static_cast<std::size_t>(found - signals.begin());
  std::vector<double> values;
  values.reserve(rows.size());
  for (const std::vector<double>& row : rows) {
    values.push_back(row[at]);
  }
  return values;
}

std::string to_csv(const Recording& recording) {
  std::string text;
  for (const std::string& comment : recording.comments) {
    text += fmt::format("# {}\n", files::printable(comment));
  }
  text += fmt::format("time_s,{}\n", fmt::join(recording.signals, ","));
  for (std::size_t i = 0; i < recording.rows.size(); ++i) {
    text += fmt::format("{:.9g}", static_cast<double>(i) * recording.period_s);
    for (const double value : recording.rows[i]) {
      text += std::isfinite(value) ? fmt::format(",{}", static_cast<float>(value)) : ",";
    }
    text += '\n';
  }
  return text;
}

Recording load_recording(const std::string& path) {
  std::ifstream in(path);
  std::string line;
  unsigned number = 1;
  Recording recording;
  while (std::getline(in, line) && line.starts_with('#')) {
    recording.comments.push_back(line.substr(std::min(line.find_first_not_of("# "), line.size())));
    ++number;
  }
  if (!line.starts_with("time_s,")) {
    throw files::UserError(fmt::format(
        "{}: is not a recording: its first line without # must begin with time_s,", path));
  }
  // The appended comma preserves an empty last field.
  std::istringstream header(line.substr(line.find(',') + 1) + ",");
  for (std::string name; std::getline(header, name, ',');) {
    recording.signals.push_back(name);
  }
  if (std::ranges::count(recording.signals, "") != 0) {
    throw files::UserError(fmt::format("{}: each column needs the name of a signal", path));
  }
  double last_s = 0;
  for (++number; std::getline(in, line); ++number) {
    std::istringstream fields(line + ",");
    std::vector<double> row;
    for (std::string field; std::getline(fields, field, ',');) {
      row.push_back(field_number(field, path, number));
    }
    if (row.size() != recording.signals.size() + 1) {
      throw files::UserError(
          fmt::format("{}:{}: must have {} fields", path, number, recording.signals.size() + 1));
    }
    take_time(row.front(), recording, last_s, fmt::format("{}:{}", path, number));
    recording.rows.emplace_back(row.begin() + 1, row.end());
  }
  return recording;
}

}  // namespace smaservo::can
