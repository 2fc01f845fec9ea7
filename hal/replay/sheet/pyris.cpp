#include "hal/replay/sheet/pyris.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "hal/recording/trimmed.hpp"
#include "hal/replay/sheet/layout.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::hal {
namespace {

/// The sample follows the program from where it has this share of the program's rate.
constexpr double following = 0.95;

/// What a line such as "2) DSC Temperature Scan" names; empty if it is no heading of a step.
std::string_view step_of(std::string_view line) {
  line = trimmed(line);
  const std::size_t digits = std::min(line.find_first_not_of("0123456789"), line.size());
  line.remove_prefix(digits);
  constexpr std::string_view mark = ") DSC ";
  return digits > 0 && line.starts_with(mark) ? trimmed(line.substr(mark.size()))
                                              : std::string_view();
}

std::vector<std::string> fields_of(std::string_view line) {
  std::vector<std::string> fields;
  split_sheet_line(line, '\t', fields);
  return fields;
}

/// The number; NaN if the text is none.
double number_in(std::string_view text, char decimal) {
  double value = std::nan("");
  if (const auto plain = plain_number(text, decimal)) {
    std::from_chars(plain->data(), plain->data() + plain->size(), value);
  }
  return value;
}

}  // namespace

std::optional<PyrisExport> PyrisExport::find(const std::vector<std::string_view>& lines) {
  const auto heading =
      std::ranges::find_if(lines, [](std::string_view line) { return !step_of(line).empty(); });
  const auto at = static_cast<std::size_t>(heading - lines.begin());
  if (lines.empty() || !trimmed(lines.front()).starts_with("Filename:") || at + 2 >= lines.size()) {
    return std::nullopt;
  }
  PyrisExport found;
  found.find_weight(lines, at);
  found.find_columns(lines, at);
  // The heading is read again as the first line, since it tells the first step.
  found.first_ = at + 1;
  return found;
}

void PyrisExport::find_weight(const std::vector<std::string_view>& lines, std::size_t heading) {
  constexpr std::string_view mark = "Sample Weight:";
  for (std::size_t i = 0; i < heading; ++i) {
    const std::string_view line = trimmed(lines[i]);
    if (!line.starts_with(mark)) {
      continue;
    }
    const std::string_view text = trimmed(line.substr(mark.size()));
    const std::size_t blank = text.find(' ');
    decimal_ = text.find(',') == std::string_view::npos ? '.' : ',';
    weight_mg_ = number_in(text.substr(0, blank), decimal_);
    const bool in_mg =
        blank != std::string_view::npos && trimmed(text.substr(blank)) == std::string_view("mg");
    if (!in_mg || !(weight_mg_ > 0)) {
      throw files::UserError(fmt::format(
          "line {}: an export of Pyris whose sample weighs '{}'; that must be a number above 0 and "
          "mg, since the flow of heat counts per weight",
          i + 1, files::printable(text)));
    }
    return;
  }
  throw files::UserError(
      "an export of Pyris without a line 'Sample Weight:'; add it with the weight in mg, since the "
      "flow of heat counts per weight");
}

/// The names of the columns are spread over the two lines below the first heading.
void PyrisExport::find_columns(const std::vector<std::string_view>& lines, std::size_t heading) {
  std::vector<std::string> names = fields_of(lines[heading + 1]);
  const std::vector<std::string> below = fields_of(lines[heading + 2]);
  for (std::size_t i = 0; i < std::min(names.size(), below.size()); ++i) {
    names[i] += below[i].empty() ? "" : " " + below[i];
  }
  fields_ = names.size();
  const auto place = [&](std::string_view name) {
    return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
  };
  const std::size_t unsubtracted = place("Unsubtracted Heat Flow");
  columns_ = {place("Time"), unsubtracted < fields_ ? unsubtracted : place("Heat Flow"),
              place("Baseline Heat Flow"), place("Program Temperature"),
              place("Sample Temperature")};
  has_baseline_ = columns_[baseline] < fields_;
  constexpr std::string_view needed[] = {"Time", "Unsubtracted Heat Flow or Heat Flow", "",
                                         "Program Temperature", "Sample Temperature"};
  for (std::size_t i = 0; i < place_count; ++i) {
    if (i != baseline && columns_.at(i) >= fields_) {
      throw files::UserError(fmt::format(
          "lines {} and {}: an export of Pyris without the column {}; export that as well",
          heading + 2, heading + 3, needed[i]));
    }
  }
}

/// Whether the sample has begun to follow the program. The row before is needed for that.
bool PyrisExport::follows(const std::array<double, place_count>& row) {
  if (before_ && !follows_) {
    const double asked_K = std::abs(row[program] - (*before_)[program]);
    const double made_K = std::abs(row[sample] - (*before_)[sample]);
    follows_ = asked_K > 0 && made_K > following * asked_K;
  }
  before_ = row;
  return follows_;
}

bool PyrisExport::take(std::string_view line, std::vector<std::string>& row) {
  if (const std::string_view step = step_of(line); !step.empty()) {
    scans_ = step.find("Temperature Scan") != std::string_view::npos;
    follows_ = false;
    before_.reset();
    return false;
  }
  // A row ends with a blank behind its last number; lines below the rows have fewer fields.
  const std::vector<std::string> fields = fields_of(line);
  if (!scans_ || fields.size() != fields_) {
    return false;
  }
  std::array<double, place_count> now{};
  for (std::size_t i = 0; i < place_count; ++i) {
    now.at(i) = i == baseline && !has_baseline_ ? 0 : number_in(fields[columns_.at(i)], decimal_);
  }
  // The names stand among the rows of the first step.
  if (std::ranges::any_of(now, [](double x) { return std::isnan(x); }) || !follows(now)) {
    return false;
  }
  constexpr double s_per_min = 60;
  row = {fmt::format("{}", s_per_min * now[time]), fmt::format("{}", now[sample]),
         fmt::format("{}", (now[flow] - now[baseline]) / weight_mg_)};
  return true;
}

std::string PyrisExport::said() const {
  return fmt::format("export of Pyris, {} mg, scans without their holds{}", weight_mg_,
                     has_baseline_ ? ", heat flow less its baseline" : "");
}

}  // namespace smaservo::hal
