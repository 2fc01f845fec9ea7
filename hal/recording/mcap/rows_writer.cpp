#include "hal/recording/mcap/rows_writer.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "hal/recording/mcap/row_object.hpp"
#include "model/files/error.hpp"
#include "model/units.hpp"

namespace smaservo::hal::mcap {
namespace {

constexpr std::size_t enough_rows = std::size_t{1} << 16U;
/// Time from one row to the next in a trace that has no column of times.
constexpr std::uint64_t step_ns = 1'000'000;
constexpr std::size_t longest_line = std::size_t{1} << 20U;
constexpr double latest_ns = 1.8e19;

/// Shortens a number that begins with zeros, which as_number() takes for a name. Empty if it does
/// not begin with zeros.
std::string_view without_zeros(std::string_view field, std::string& room) {
  const std::string_view sign = field.substr(0, field.starts_with('-') ? 1 : 0);
  std::string_view digits = field.substr(sign.size());
  while (digits.size() > 1 && digits[0] == '0' && digits[1] >= '0' && digits[1] <= '9') {
    digits.remove_prefix(1);
  }
  if (digits.size() + sign.size() == field.size()) {
    return "";
  }
  const std::string shorter = fmt::format("{}{}", sign, digits);
  std::string other;
  room = as_number(shorter, other);
  return room;
}

constexpr std::string_view written_by = "smaservo " SMASERVO_VERSION;

}  // namespace

RowsWriter::RowsWriter(const Origin& origin, std::vector<Kind> kinds, bool compressed)
    : origin_(origin), kinds_(std::move(kinds)), writer_(written_by, compressed) {}

void RowsWriter::fail(std::uint64_t line, std::string_view what) {
  throw files::UserError(fmt::format("line {}: {}", line, what));
}

void RowsWriter::add(std::string_view csv) {
  for (;;) {
    const std::size_t end = csv.find('\n');
    if (end == std::string_view::npos) {
      rest_ += csv;
      if (rest_.size() > longest_line) {
        fail(lines_ + 1, fmt::format("longer than {} bytes; is this a CSV file?", longest_line));
      }
      return;
    }
    if (rest_.empty()) {
      line(csv.substr(0, end));
    } else {
      rest_ += csv.substr(0, end);
      line(rest_);
      rest_.clear();
    }
    csv.remove_prefix(end + 1);
  }
}

void RowsWriter::line(std::string_view text) {
  ++lines_;
  if (text.ends_with('\r')) {
    text.remove_suffix(1);
  }
  if (!has_header_) {
    header(text);
  } else if (!text.empty()) {
    row(text);
  }
}

void RowsWriter::header(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) {
    text.remove_prefix(3);
  }
  has_header_ = true;
  header_ = text;
  for (std::string& name : header_names(text)) {
    columns_.push_back({std::move(name)});
  }
  bool known = true;
  time_column_ = columns_.size();
  for (std::size_t i = columns_.size(); i-- > 0;) {
    columns_[i].kind = i < kinds_.size() ? kinds_[i] : Kind::unknown;
    if (const auto unit = unit_of(columns_[i].name, "time", kind::time)) {
      time_column_ = i;
      time_scale_ = unit->to_si(1e9);
      columns_[i].kind = Kind::number;
    }
    known = known && columns_[i].kind != Kind::unknown;
  }
  counts_.resize(columns_.size());
  left_out_.resize(columns_.size());
  if (known) {
    begin();
  }
}

void RowsWriter::Place::add(std::uint64_t at, std::string_view what) {
  if (count++ == 0) {
    line = at;
    text = what;
  }
}

/// Writes what stands before the first message, and the rows that had to wait for it.
void RowsWriter::begin() {
  if (begun_) {
    return;
  }
  begun_ = true;
  if (!has_header_) {
    throw files::UserError("is empty; a trace starts with a row of column names");
  }
  writer_.metadata("smaservo",
                   {{"version", SMASERVO_VERSION},
                    {"program", origin_.program},
                    {"source", origin_.source},
                    {"log_time", time_column_ < columns_.size() ? columns_[time_column_].name
                                                                : "1 ms for each row"}});
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    columns_[i].kind = columns_[i].kind == Kind::unknown ? counts_[i].kind() : columns_[i].kind;
  }
  try {
    writer_.stream({"smaservo.Trace", schema_of(columns_), "/trace"});
  } catch (const files::UserError& problem) {
    fail(1, problem.what());
  }
  for (const TraceColumn& column : columns_) {
    std::string& name = names_.emplace_back();
    put_json_text(name, column.name);
    name += ':';
  }
  std::size_t from = 0;
  for (const std::uint64_t line : first_lines_) {
    const std::size_t end = first_rows_.find('\n', from);
    split_row(std::string_view(first_rows_).substr(from, end - from), columns_.size(), fields_);
    encode(fields_, line);
    from = end + 1;
  }
  first_rows_ = {};
  first_lines_ = {};
}

void RowsWriter::row(std::string_view text) {
  if (text == header_) {
    headers_.add(lines_, text);
    return;
  }
  if (!split_row(text, columns_.size(), fields_)) {
    fail(lines_, fmt::format("the row has {} columns, the header {}",
                             std::ranges::count(text, ',') + 1, columns_.size()));
  }
  ++rows_;
  if (begun_) {
    encode(fields_, lines_);
    return;
  }
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    counts_[i].add(fields_[i], lines_);
  }
  first_lines_.push_back(lines_);
  first_rows_ += text;
  first_rows_ += '\n';
  if (first_rows_.size() >= enough_rows) {
    begin();
  }
}

void RowsWriter::encode(const std::vector<std::string_view>& fields, std::uint64_t line) {
  object_ = '{';
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (!fields[i].empty()) {
      value(i, fields[i], line);
    }
  }
  object_ += '}';
  writer_.message(time_ns(fields, line), object_);
}

/// Adds a member to the object, of the kind that the schema gives its column.
void RowsWriter::value(std::size_t column, std::string_view field, std::uint64_t line) {
  const std::size_t before = object_.size();
  object_ += before == 1 ? "" : ",";
  object_ += names_[column];
  if (columns_[column].kind == Kind::number) {
    std::string_view number = as_number(field, number_);
    if (number.empty()) {
      number = without_zeros(field, number_);
    }
    if (number.empty()) {
      object_.resize(before);
      left_out_[column].add(line, field);
    }
    object_ += number;
  } else if (!put_json_text(object_, field)) {
    fail(line, fmt::format("column {} ({}): '{}' is no UTF-8, which texts in an MCAP file must be",
                           column + 1, columns_[column].name, field));
  }
}

/// The time of the row; a row without a time gets that of the row before. Times never fall back:
/// where the trace's clock fell back, they continue from the last time.
std::uint64_t RowsWriter::time_ns(const std::vector<std::string_view>& fields, std::uint64_t line) {
  const bool first = writer_.messages() == 0;
  if (time_column_ == fields.size()) {
    last_ns_ += first ? 0 : step_ns;
    return last_ns_;
  }
  const std::string_view field = fields[time_column_];
  double value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error == std::errc{} && end == field.data() + field.size() && std::isfinite(value)) {
    const double ns = value * time_scale_;
    shift_ns_ = first ? std::max(0.0, -ns) : shift_ns_;
    if (!first && ns + shift_ns_ < static_cast<double>(last_ns_)) {
      shift_ns_ = static_cast<double>(last_ns_ + gap_ns_) - ns;
      falls_back_.add(line, field);
    }
    const auto now_ns =
        static_cast<std::uint64_t>(std::round(std::clamp(ns + shift_ns_, 0.0, latest_ns)));
    gap_ns_ = first ? gap_ns_ : now_ns - last_ns_;
    ++times_;
    last_ns_ = now_ns;
  }
  return last_ns_;
}

std::vector<std::string> RowsWriter::remarks() const {
  std::vector<std::string> all;
  const auto times = [](const Place& place) {
    return place.count == 1 ? "" : fmt::format(", and {} more", place.count - 1);
  };
  if (headers_.count > 0) {
    all.push_back(fmt::format("line {}: the header stands here again: left out{}", headers_.line,
                              times(headers_)));
  }
  if (falls_back_.count > 0) {
    all.push_back(
        fmt::format("line {}, column {} ({}): time {} comes after a later one: log_time "
                    "goes on from there{}",
                    falls_back_.line, time_column_ + 1, columns_[time_column_].name,
                    falls_back_.text, times(falls_back_)));
  }
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const std::string place = fmt::format("column {} ({})", i + 1, columns_[i].name);
    if (left_out_[i].count > 0) {
      all.push_back(fmt::format("line {}, {}: '{}' in a column of numbers: left out{}",
                                left_out_[i].line, place, left_out_[i].text, times(left_out_[i])));
    }
  }
  return all;
}

void RowsWriter::flush() {
  if (has_header_) {
    begin();
  }
  writer_.close_chunk();
}

void RowsWriter::finish() {
  if (!rest_.empty()) {
    add("\n");  // most programs write no end of the last line
  }
  begin();
  if (time_column_ < columns_.size() && 9 * left_out_[time_column_].count > times_) {
    const Place& place = left_out_[time_column_];
    fail(place.line, fmt::format("column {} ({}): '{}' is no number, of which log_time is made",
                                 time_column_ + 1, columns_[time_column_].name, place.text));
  }
  writer_.finish();
}

}  // namespace smaservo::hal::mcap
