#include "model/files/mcap/rows_writer.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "model/files/error.hpp"
#include "model/files/mcap/row_object.hpp"
#include "model/units.hpp"

namespace smaservo::files::mcap {
namespace {

constexpr std::size_t enough_rows = std::size_t{1} << 16U;
/// Between rows that have no time.
constexpr std::uint64_t step_ns = 1'000'000;
constexpr std::size_t longest_line = std::size_t{1} << 20U;
constexpr double latest_ns = 1.8e19;

constexpr std::string_view written_by = "smaservo " SMASERVO_VERSION;

}  // namespace

RowsWriter::RowsWriter(const Origin& origin, std::vector<Kind> kinds, bool compressed)
    : origin_(origin), kinds_(std::move(kinds)), writer_(written_by, compressed) {}

void RowsWriter::fail(std::uint64_t line, std::string_view what) {
  throw UserError(fmt::format("line {}: {}", line, what));
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
  if (known) {
    begin();
  }
}

/// Writes what stands before the first message, and the rows that have waited for it.
void RowsWriter::begin() {
  if (begun_) {
    return;
  }
  begun_ = true;
  if (!has_header_) {
    throw UserError("is empty; a trace starts with a row of column names");
  }
  writer_.metadata("smaservo",
                   {{"version", SMASERVO_VERSION},
                    {"program", origin_.program},
                    {"source", origin_.source},
                    {"log_time", time_column_ < columns_.size() ? columns_[time_column_].name
                                                                : "1 ms for each row"}});
  try {
    writer_.stream({"smaservo.Trace", schema_of(columns_), "/trace"});
  } catch (const UserError& problem) {
    fail(1, problem.what());
  }
  for (const TraceColumn& column : columns_) {
    std::string& name = names_.emplace_back();
    put_json_text(name, column.name);
    name += ':';
  }
  std::uint64_t line = first_line_;
  for (std::size_t from = 0; from < first_rows_.size(); ++line) {
    const std::size_t end = first_rows_.find('\n', from);
    split_row(std::string_view(first_rows_).substr(from, end - from), columns_.size(), fields_);
    encode(fields_, line);
    from = end + 1;
  }
  first_rows_ = {};
}

void RowsWriter::row(std::string_view text) {
  if (!split_row(text, columns_.size(), fields_)) {
    fail(lines_, fmt::format("the row has {} columns, the header {}",
                             std::ranges::count(text, ',') + 1, columns_.size()));
  }
  ++rows_;
  if (begun_) {
    encode(fields_, lines_);
    return;
  }
  learn(columns_, fields_);
  first_line_ = first_rows_.empty() ? lines_ : first_line_;
  first_rows_ += text;
  first_rows_ += '\n';
  if (first_rows_.size() >= enough_rows) {
    begin();
  }
}

void RowsWriter::encode(const std::vector<std::string_view>& fields, std::uint64_t line) {
  object_ = '{';
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (fields[i].empty()) {
      continue;
    }
    object_ += object_.size() == 1 ? "" : ",";
    object_ += names_[i];
    const std::string_view number =
        columns_[i].kind == Kind::number ? as_number(fields[i], number_) : "";
    if (!number.empty()) {
      object_ += number;
    } else if (!put_json_text(object_, fields[i])) {
      fail(line,
           fmt::format("column {} ({}): '{}' is no UTF-8, which texts in an MCAP file must be",
                       i + 1, columns_[i].name, fields[i]));
    }
  }
  object_ += '}';
  writer_.message(time_ns(fields), object_);
}

/// The row's time; that of the row before where it has none.
std::uint64_t RowsWriter::time_ns(const std::vector<std::string_view>& fields) {
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
    last_ns_ = static_cast<std::uint64_t>(std::round(std::clamp(ns + shift_ns_, 0.0, latest_ns)));
  }
  return last_ns_;
}

void RowsWriter::flush() {
  if (has_header_) {
    begin();
  }
  writer_.close_chunk();
}

void RowsWriter::finish() {
  if (!rest_.empty()) {
    fail(lines_ + 1, "the last line has no end; the file seems to be cut off");
  }
  begin();
  writer_.finish();
}

}  // namespace smaservo::files::mcap
