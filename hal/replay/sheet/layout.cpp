#include "hal/replay/sheet/layout.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "hal/recording/trimmed.hpp"
#include "hal/replay/sheet/meaning.hpp"

namespace smaservo::hal {
namespace {

bool is_digit(char c) {
  return '0' <= c && c <= '9';
}
bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

/// Reads `count` digits, at most four; -1 where there are none.
int take_digits(std::string_view& text, std::size_t least, std::size_t most) {
  int value = 0;
  std::size_t n = 0;
  while (n < most && n < text.size() && is_digit(text[n])) {
    value = 10 * value + (text[n] - '0');
    ++n;
  }
  if (n < least) {
    return -1;
  }
  text.remove_prefix(n);
  return value;
}

bool take(std::string_view& text, char c) {
  const bool there = text.starts_with(c);
  text.remove_prefix(there ? 1 : 0);
  return there;
}

/// Days from 1970-01-01 in the Gregorian calendar; its cycle of 400 years begins in March.
long days_of(int year, int month, int day) {
  const long y = month <= 2 ? year - 1 : year;
  const long era = y / 400;
  const long of_era = y - era * 400;
  const long of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  return era * 146097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719468;
}

/// `2026-11-28`, `28.11.2026`, `11/28/2026` or `28/11/2026`, and what separates it from the clock.
/// With slashes nobody knows whether the month comes first, unless the other number is no month or
/// the same.
std::optional<long> take_date(std::string_view& text) {
  std::string_view rest = text;
  const int first = take_digits(rest, 1, 4);
  const char between = rest.empty() ? '\0' : rest.front();
  if (first < 0 || (between != '-' && between != '.' && between != '/')) {
    return std::nullopt;
  }
  rest.remove_prefix(1);
  const int second = take_digits(rest, 1, 2);
  if (second < 1 || !take(rest, between)) {
    return std::nullopt;
  }
  const int last = take_digits(rest, 1, 4);
  const bool month_first = between == '/' && second > 12;
  const bool year_first = between == '-' || first > 31;
  const int month = month_first ? first : second;
  const int year = year_first ? first : last;
  const int day = year_first ? last : month_first ? second : first;
  const bool unknown =
      between == '/' && !year_first && first <= 12 && second <= 12 && first != second;
  if (unknown || month < 1 || 12 < month || year < 1970 || day < 1 || 31 < day ||
      !(take(rest, 'T') || take(rest, ' '))) {
    return std::nullopt;
  }
  text = trimmed(rest);
  return days_of(year, month, day);
}

/// What stands behind a clock, in seconds to add: `Z`, `+01:00`, ` AM`, ` PM`, or nothing.
std::optional<long> take_zone(std::string_view text, int hours) {
  text = trimmed(text);
  if (text.empty() || text == "Z") {
    return 0;
  }
  if (text == "AM" || text == "am" || text == "PM" || text == "pm") {
    if (hours < 1 || 12 < hours) {
      return std::nullopt;
    }
    const bool afternoon = text.front() == 'P' || text.front() == 'p';
    return (afternoon ? (hours == 12 ? 0 : 12) : (hours == 12 ? -12 : 0)) * 3600L;
  }
  const bool east = take(text, '+');
  if (!east && !take(text, '-')) {
    return std::nullopt;
  }
  const int zone_hours = take_digits(text, 2, 2);
  take(text, ':');
  const int zone_minutes = text.empty() ? 0 : take_digits(text, 2, 2);
  if (zone_hours < 0 || zone_minutes < 0 || !text.empty()) {
    return std::nullopt;
  }
  return (east ? -60L : 60L) * (60 * zone_hours + zone_minutes);
}

std::optional<std::string> seconds_of_clock(std::string_view text, char decimal) {
  const long days = take_date(text).value_or(0);
  const int hours = take_digits(text, 1, 2);
  if (hours < 0 || !take(text, ':')) {
    return std::nullopt;
  }
  const int minutes = take_digits(text, 2, 2);
  if (minutes < 0 || 59 < minutes || !take(text, ':')) {
    return std::nullopt;
  }
  const int seconds = take_digits(text, 2, 2);
  if (seconds < 0 || 60 < seconds) {
    return std::nullopt;
  }
  std::string_view decimals;
  if (take(text, '.') || take(text, decimal)) {
    const auto* const end = std::ranges::find_if_not(text, is_digit);
    decimals = text.substr(0, static_cast<std::size_t>(end - text.begin()));
    text.remove_prefix(decimals.size());
  }
  const std::optional<long> zone_s = take_zone(text, hours);
  const long whole = ((days * 24 + hours) * 60 + minutes) * 60 + seconds + zone_s.value_or(0);
  if (!zone_s || whole < 0) {
    return std::nullopt;
  }
  return decimals.empty() ? fmt::format("{}", whole) : fmt::format("{}.{}", whole, decimals);
}

/// What a pair of separator and decimal sign makes of the lines.
struct Reading {
  char separator, decimal;
  std::size_t columns = 0;       ///< of the longest run of rows
  double rows = 0, numbers = 0;  ///< of it: rows, and the share of numbers in their fields
  bool begins_with_number = false;
  std::size_t first = 0;    ///< number of the first row's line
  bool keeps_last = false;  ///< the last column is one where fields are empty, too
};

struct Counted {
  std::size_t fields, numbers;
  bool begins_with_number;
};

/// At least two numbers, and a third of the fields.
bool enough_numbers(const Counted& line) {
  return line.numbers >= 2 && 3 * line.numbers >= line.fields;
}

Counted count_numbers(const std::vector<std::string>& fields, char decimal) {
  const auto is_number = [&](const std::string& field) {
    return plain_number(field, decimal).has_value();
  };
  return {fields.size(), static_cast<std::size_t>(std::ranges::count_if(fields, is_number)),
          !fields.empty() && is_number(fields.front())};
}

Counted count(std::string_view line, const Reading& how, std::vector<std::string>& fields) {
  split_sheet_line(line, how.separator, fields);
  if (!how.keeps_last && fields.size() > 1 && fields.back().empty()) {
    fields.pop_back();
  }
  return count_numbers(fields, how.decimal);
}

/// A row has as many fields as its neighbours, and enough numbers.
void read_lines(const std::vector<std::string_view>& lines, Reading& how) {
  std::vector<std::string> fields;
  std::size_t run = 0;
  std::size_t columns = 0;
  std::size_t numbers = 0;
  for (const std::string_view line : lines) {
    if (trimmed(line).empty()) {
      continue;
    }
    const Counted now = count(line, how, fields);
    const bool is_row = enough_numbers(now);
    if (!is_row || now.fields != columns) {
      run = numbers = 0;
    }
    columns = is_row ? now.fields : 0;
    if (is_row) {
      ++run;
      numbers += now.numbers;
      if (static_cast<double>(run) > how.rows) {
        how.rows = static_cast<double>(run);
        how.columns = columns;
        how.begins_with_number = now.begins_with_number;
        how.numbers = static_cast<double>(numbers) / static_cast<double>(run * columns);
      }
    }
  }
}

/// Whether the lines have one more column than the longest run of rows has, which is empty there:
/// its separator is in each of the rows, and in one of them, or above them, is a text.
bool has_sparse_last(const std::vector<std::string_view>& lines, const Reading& how) {
  std::vector<std::string> fields;
  bool any = false;
  bool in_rows = false;
  for (const std::string_view line : lines) {
    const std::size_t numbers = count(line, how, fields).numbers;
    split_sheet_line(line, how.separator, fields);
    const bool whole = fields.size() == how.columns + 1;
    const bool is_row = numbers >= 2 && 3 * numbers >= how.columns;
    if (is_row && !whole) {
      return false;
    }
    in_rows = in_rows || is_row;
    any = any || (whole && !fields.back().empty() && (is_row || !in_rows));
  }
  return in_rows && any;
}

/// The first line that is a row as those of the longest run are.
void find_first(const std::vector<std::string_view>& lines, Reading& how) {
  std::vector<std::string> fields;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Counted now = count(lines[i], how, fields);
    if (now.fields == how.columns && enough_numbers(now) &&
        now.begins_with_number == how.begins_with_number) {
      how.first = i + 1;
      return;
    }
  }
}

/// The last line above `line` that is not empty; 0: there is none.
std::size_t line_above(const std::vector<std::string_view>& lines, std::size_t line) {
  while (line > 1 && trimmed(lines[line - 2]).empty()) {
    --line;
  }
  return line - 1;
}

/// Where blanks separate, a unit in brackets belongs to the name before it.
void join_units(std::vector<std::string>& fields) {
  for (std::size_t i = 1; i < fields.size();) {
    const bool unit = fields[i].starts_with('[') || fields[i].starts_with('(');
    const bool name = !fields[i - 1].starts_with('[') && !fields[i - 1].starts_with('(');
    if (unit && name) {
      fields[i - 1] += " " + fields[i];
      fields.erase(fields.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
}

/// The fields of a line of names or units, which may be a comment; none if their number differs.
std::vector<std::string> fields_above(const std::vector<std::string_view>& lines, std::size_t line,
                                      const SheetLayout& layout) {
  std::vector<std::string> fields;
  if (line == 0) {
    return fields;
  }
  std::string_view text = trimmed(lines[line - 1]);
  while (text.starts_with('#') || text.starts_with('%')) {
    text = trimmed(text.substr(1));
  }
  split_sheet_line(text, layout.separator, fields);
  if (layout.separator == ' ') {
    join_units(fields);
  }
  // LabVIEW names a last column for comments, which most rows do not have.
  if (fields.size() == layout.columns + 1) {
    fields.pop_back();
  }
  if (fields.size() != layout.columns) {
    fields.clear();
  }
  return fields;
}

void find_names(const std::vector<std::string_view>& lines, SheetLayout& layout) {
  const std::size_t above = line_above(lines, layout.first);
  std::vector<std::string> fields = fields_above(lines, above, layout);
  const std::size_t over = above == 0 ? 0 : line_above(lines, above);
  std::vector<std::string> names = fields_above(lines, over, layout);
  const bool units = !fields.empty() && !names.empty() &&
                     std::ranges::all_of(fields, [](const auto& f) { return is_unit_field(f); });
  layout.units = units ? above : 0;
  layout.header = units ? over : fields.empty() ? 0 : above;
  for (std::size_t i = 0; units && i < names.size(); ++i) {
    const bool bare = !fields[i].empty() && fields[i].front() != '[' && fields[i].front() != '(';
    names[i] += bare ? fmt::format(" [{}]", fields[i]) : fields[i].empty() ? "" : " " + fields[i];
  }
  layout.names = units ? names : fields;
  for (std::size_t i = 0; fields.empty() && i < layout.columns; ++i) {
    layout.names.push_back(fmt::format("{}", i + 1));
  }
}

}  // namespace

bool is_sheet_row(const std::vector<std::string>& fields, const SheetLayout& layout) {
  const Counted line = count_numbers(fields, layout.decimal);
  return line.fields == layout.columns && 3 * line.numbers >= line.fields &&
         line.begins_with_number == layout.begins_with_number;
}

void split_sheet_line(std::string_view line, char separator, std::vector<std::string>& fields) {
  fields.clear();
  std::string field;
  bool quoted = false;
  const auto end_field = [&] {
    fields.emplace_back(trimmed(field));
    field.clear();
  };
  line = separator == ' ' ? trimmed(line) : line;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') {
      const bool doubled = quoted && i + 1 < line.size() && line[i + 1] == '"';
      field += doubled ? "\"" : "";
      i += doubled ? 1 : 0;
      quoted = doubled ? quoted : !quoted;
    } else if (!quoted && separator == ' ' && is_blank(c)) {
      while (i + 1 < line.size() && is_blank(line[i + 1])) {
        ++i;
      }
      end_field();
    } else if (!quoted && c == separator) {
      end_field();
    } else {
      field += c;
    }
  }
  end_field();
}

std::optional<std::string> plain_number(std::string_view field, char decimal) {
  field = trimmed(field);
  std::string text(field.starts_with('+') ? field.substr(1) : field);
  if (text.empty() || !(is_digit(text.front()) || text.front() == '-' || text.front() == '.' ||
                        text.front() == decimal)) {
    return std::nullopt;
  }
  if (text.find(':') != std::string::npos) {
    return seconds_of_clock(text, decimal);
  }
  if (decimal == ',') {
    if (text.find('.') != std::string::npos) {
      return std::nullopt;
    }
    std::ranges::replace(text, ',', '.');
  }
  double value = 0;
  const char* const stop = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), stop, value);
  if (error != std::errc{} || at != stop || !std::isfinite(value)) {
    return std::nullopt;
  }
  return text;
}

std::optional<SheetLayout> find_layout(const std::vector<std::string_view>& lines) {
  constexpr std::pair<char, char> candidates[] = {{',', '.'},  {';', '.'},  {';', ','},
                                                  {'\t', '.'}, {'\t', ','}, {'|', '.'},
                                                  {'|', ','},  {' ', '.'},  {' ', ','}};
  std::optional<Reading> best;
  for (const auto& [separator, decimal] : candidates) {
    Reading how{separator, decimal};
    read_lines(lines, how);
    // A field that two separators leave whole is no number; so the better reading has more of them.
    if (how.rows > 0 && (!best || how.rows * how.numbers > 1.01 * best->rows * best->numbers)) {
      best = how;
    }
  }
  if (!best) {
    return std::nullopt;
  }
  if (best->separator != ' ' && has_sparse_last(lines, *best)) {
    best->keeps_last = true;
    ++best->columns;
  }
  find_first(lines, *best);
  SheetLayout layout{best->separator,
                     best->decimal,
                     best->columns,
                     0,
                     0,
                     best->first,
                     best->begins_with_number,
                     {}};
  find_names(lines, layout);
  return layout;
}

}  // namespace smaservo::hal
