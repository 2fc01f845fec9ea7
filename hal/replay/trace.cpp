#include "hal/replay/trace.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <optional>
#include <span>

#include "hal/replay/trace_text.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/units.hpp"

namespace smaservo::hal {
namespace {

struct Known {
  std::string_view base;
  Kind kind;
  double low, high;  ///< bounds in SI; a value outside makes the row a bad one
};

constexpr std::array<Known, column_count> known_columns{{
    {"time", kind::time, -9e9, 9e9},
    {"current", kind::current, -1e3, 1e3},
    {"voltage", kind::voltage, -1e4, 1e4},
    {"load", kind::force, -1e3, 1e5},
    {"stress", kind::stress, -1e9, 1e10},
    {"temperature", kind::temperature, 50, 2000},
    {"ambient", kind::temperature, 150, 500},
    {"strain_ref", kind::number, -1, 1},
    {"displacement", kind::length, -10, 10},
    {"resistance", kind::resistance, 0, 1e6},
    {"power", kind::specific_power, -1e7, 1e7},
    {"supply", kind::voltage, -1e4, 1e4},
    {"driver", kind::temperature, 50, 2000},
    {"emergency_stop", kind::count, 0, 1},
    {"driver_fault", kind::count, 0, 1},
    {"sequence", kind::count, 0, 4294967295.0},
    {"fresh", kind::count, 0, 1},
}};

/// Whether a reader with these options understands the column.
constexpr bool understood(Column column, const TraceOptions& options) {
  return column < Column::resistance ||
         (column < Column::supply ? options.resistance_and_power : options.device);
}

/// Whether the column's fields may be empty: a reading may have failed, while time, sequence and
/// flags are always there.
constexpr bool may_be_empty(Column column, const TraceOptions& options) {
  return options.device && column != Column::time &&
         (column <= Column::ambient || column == Column::supply || column == Column::driver);
}

constexpr std::size_t buffer_size = std::size_t{1} << 20;
constexpr std::size_t max_complaints = 10;
constexpr double not_there = std::numeric_limits<double>::quiet_NaN();

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) {
    text.remove_prefix(1);
  }
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) {
    text.remove_suffix(1);
  }
  return text;
}

/// Reads a number at `at` and moves `at` behind it; NaN where there is none. A plain decimal of up
/// to 15 digits takes one exact division (Clinger 1990); the standard library parses the others, in
/// four times the time.
double parse_number(const char*& at, const char* stop) {
  constexpr std::array<double, 16> powers{1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                          1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
  const char* p = at;
  const bool negative = p < stop && *p == '-';
  p += negative ? 1 : 0;
  std::uint64_t digits = 0;
  const auto read_digits = [&] {
    const char* from = p;
    for (; p < stop && *p >= '0' && *p <= '9'; ++p) {
      digits = 10 * digits + static_cast<std::uint64_t>(*p - '0');
    }
    return p - from;
  };
  const auto whole = read_digits();
  std::ptrdiff_t decimals = 0;
  if (p < stop && *p == '.') {
    ++p;
    decimals = read_digits();
  }
  if (whole > 0 && whole + decimals <= 15 && (p == stop || *p == ',')) {
    at = p;
    const double value = static_cast<double>(digits) / powers[static_cast<std::size_t>(decimals)];
    return negative ? -value : value;
  }
  double value = 0;
  const auto [after, error] = std::from_chars(at, stop, value);
  if (error != std::errc{} || !(after == stop || *after == ',')) {
    return not_there;
  }
  at = after;
  return value;
}

/// What the header says of one column.
struct Target {
  std::size_t value = column_count;  ///< index into TraceRow::values; column_count: keep as text
  Unit unit{"", 1};
  double scale = 1;  ///< factor given with a rename
};

struct BadRow {
  std::size_t column;
  std::string reason;
};

}  // namespace

struct TraceReader::Impl {
  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() = default;

  std::string path;
  TraceOptions options;
  std::unique_ptr<TraceText> source;
  std::vector<char> buffer = std::vector<char>(buffer_size);
  std::size_t begin = 0, end = 0;  ///< unread bytes in the buffer
  bool at_end = false;
  std::uint64_t line = 0, rows = 0, skipped = 0;
  std::vector<std::string> names;
  std::vector<Target> targets;
  std::vector<std::size_t> unknown;
  std::array<bool, column_count> has{};
  double last_time_s = -std::numeric_limits<double>::infinity();
  std::vector<std::string> complaints;
  bool said_cut_off = false;

  [[noreturn]] void fail(const std::string& reason) const {
    throw TraceError(fmt::format("{}: {}", path, reason));
  }

  void open_file() {
    const std::string name = path;
    if (path == "-") {
      path = "standard input";
    }
    try {
      source = std::make_unique<TraceText>(name);
    } catch (const files::UserError& problem) {
      fail(problem.what());
    }
  }

  void fill() {
    if (begin > 0) {
      std::memmove(buffer.data(), buffer.data() + begin, end - begin);
      end -= begin;
      begin = 0;
    }
    if (end == buffer.size()) {
      fail(fmt::format("{}: longer than {} bytes{}", place(line + 1), buffer.size(),
                       source->is_mcap() ? "" : "; is this a CSV file?"));
    }
    try {
      const std::size_t got = source->read(buffer.data() + end, buffer.size() - end);
      at_end = got == 0;
      end += got;
    } catch (const files::UserError& problem) {
      fail(source->is_mcap() ? problem.what() : place(line + 1) + ": " + problem.what());
    }
  }

  std::string place(std::uint64_t number) const { return source->place(number); }

  /// Reads the next line, without its end; `complete` says whether it had an end.
  bool next_line(std::string_view& text, bool& complete) {
    std::size_t searched = begin;
    for (;;) {
      const char* from = buffer.data() + searched;
      const void* found = std::memchr(from, '\n', end - searched);
      if (found != nullptr || (at_end && begin < end)) {
        complete = found != nullptr;
        const char* start = buffer.data() + begin;
        const char* stop = complete ? static_cast<const char*>(found) : buffer.data() + end;
        text = std::string_view(start, static_cast<std::size_t>(stop - start));
        begin = static_cast<std::size_t>(stop - buffer.data()) + (complete ? 1 : 0);
        if (!text.empty() && text.back() == '\r') {
          text.remove_suffix(1);
        }
        ++line;
        return true;
      }
      if (at_end) {
        return false;
      }
      const std::size_t pending = end - begin;
      fill();
      searched = begin + pending;
    }
  }

  void read_header() {
    std::string_view text;
    bool complete = false;
    if (!next_line(text, complete)) {
      fail("is empty; a trace starts with a row of column names");
    }
    if (text.starts_with("\xEF\xBB\xBF")) {
      text.remove_prefix(3);
    }
    for (std::size_t from = 0; from <= text.size();) {
      const std::size_t comma = std::min(text.find(',', from), text.size());
      names.emplace_back(trimmed(text.substr(from, comma - from)));
      from = comma + 1;
    }
    targets.resize(names.size());
    for (const std::string& rename : options.renames) {
      apply_rename(rename);
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (targets[i].value == column_count) {
        explain(i, names[i]);
      }
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (targets[i].value == column_count) {
        unknown.push_back(i);
      }
    }
  }

  void apply_rename(const std::string& rename) {
    const std::size_t equals = rename.find('=');
    const std::size_t star = rename.find('*', equals == std::string::npos ? 0 : equals);
    if (equals == std::string::npos || equals == 0) {
      fail(fmt::format("--column {}: must be NAME=COLUMN or NAME=COLUMN*FACTOR", rename));
    }
    const std::string name = rename.substr(0, equals);
    const std::string column = rename.substr(
        equals + 1, star == std::string::npos ? std::string::npos : star - equals - 1);
    double factor = 1;
    if (star != std::string::npos) {
      const char* stop = rename.data() + rename.size();
      const auto [at, error] = std::from_chars(rename.data() + star + 1, stop, factor);
      if (error != std::errc{} || at != stop || !std::isfinite(factor) || factor == 0) {
        fail(fmt::format("--column {}: the factor must be a finite number, not 0", rename));
      }
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == column) {
        if (targets[i].value != column_count) {
          fail(fmt::format("--column {}: the column has another name already", rename));
        }
        explain(i, name);
        if (targets[i].value == column_count) {
          fail(fmt::format("--column {}: {} is no known name of a column; known are: {}", rename,
                           name, known_names()));
        }
        targets[i].scale = factor;
        return;
      }
    }
    fail(fmt::format("--column {}: there is no column {}; there are: {}", rename, column,
                     fmt::join(names, ", ")));
  }

  std::string known_names() const {
    std::vector<std::string> all;
    for (std::size_t k = 0; k < column_count; ++k) {
      const Known& column = known_columns[k];
      if (!understood(static_cast<Column>(k), options)) {
        continue;
      }
      for (const Unit& unit : column.kind) {
        all.push_back(unit.suffix.empty() ? std::string(column.base)
                                          : fmt::format("{}_{}", column.base, unit.suffix));
      }
    }
    return fmt::format("{}", fmt::join(all, ", "));
  }

  void explain(std::size_t i, const std::string& name) {
    for (std::size_t k = 0; k < column_count; ++k) {
      const Known& column = known_columns[k];
      if (!understood(static_cast<Column>(k), options)) {
        continue;
      }
      if (const auto unit = unit_of(name, column.base, column.kind)) {
        if (has[k]) {
          fail(fmt::format("{}, column {} ({}): there is another column for {}", place(1), i + 1,
                           name, column.base));
        }
        has[k] = true;
        targets[i].value = k;
        targets[i].unit = *unit;
        return;
      }
      // A known quantity in an unknown unit is an error, not an unknown column. Power in watts is
      // allowed: it is another quantity than specific power.
      if (k != static_cast<std::size_t>(Column::power) &&
          (name == column.base ||
           (name.starts_with(column.base) && name[column.base.size()] == '_' &&
            looks_like_unit(name.substr(column.base.size() + 1))))) {
        fail(fmt::format("{}, column {} ({}): {} has an unknown unit; known are: {}", place(1),
                         i + 1, name, column.base, known_names()));
      }
    }
  }

  /// Whether the text after a known name looks like a unit.
  static bool looks_like_unit(std::string_view suffix) {
    return !suffix.empty() && suffix.find('_') == std::string_view::npos && suffix.size() <= 4;
  }

  BadRow out_of_range(std::size_t i, const std::string& field) const {
    const Unit& unit = targets[i].unit;
    const Known& column = known_columns[targets[i].value];
    std::string text = fmt::format("{} is out of range, {:.4g} to {:.4g}", field,
                                   unit.from_si(column.low), unit.from_si(column.high));
    if (!unit.suffix.empty()) {
      text += fmt::format(" {}", unit.suffix);
    } else if (column.kind.size() > 1) {
      text += fmt::format("; per cent are {}_percent", column.base);
    }
    return {i, text};
  }

  std::optional<BadRow> parse(std::string_view text, TraceRow& row) {
    row.values.fill(not_there);
    row.text = text;
    const char* at = text.data();
    const char* const stop = at + text.size();
    const std::size_t columns = targets.size();
    for (std::size_t i = 0; i < columns; ++i) {
      const Target& target = targets[i];
      const char* comma = nullptr;
      if (target.value == column_count) {
        comma = static_cast<const char*>(std::memchr(at, ',', static_cast<std::size_t>(stop - at)));
        comma = comma == nullptr ? stop : comma;
      } else if ((at == stop || *at == ',') &&
                 may_be_empty(static_cast<Column>(target.value), options)) {
        comma = at;
      } else {
        comma = at;
        double value = parse_number(comma, stop);
        if (!std::isfinite(value)) {
          return bad_number(i, at, stop);
        }
        value = target.unit.to_si(value * target.scale);
        const Known& column = known_columns[target.value];
        if (!(value >= column.low && value <= column.high)) {
          return out_of_range(i, field(at, stop));
        }
        row.values[target.value] = value;
      }
      const bool last = i + 1 == columns;
      if (last != (comma == stop)) {
        return BadRow{i, wrong_count(text)};
      }
      at = comma + 1;
    }
    return std::nullopt;
  }

  static std::string field(const char* at, const char* stop) {
    const std::string_view rest(at, static_cast<std::size_t>(stop - at));
    return fmt::format("'{}'", rest.substr(0, std::min<std::size_t>(rest.find(','), 40)));
  }

  static std::optional<BadRow> bad_number(std::size_t i, const char* at, const char* stop) {
    if (at < stop && (*at == ' ' || *at == '+')) {
      return BadRow{i, fmt::format("{} begins with a space or a plus sign", field(at, stop))};
    }
    const std::string text = field(at, stop);
    return BadRow{i, text == "''" ? "the field is empty" : text + " is not a finite number"};
  }

  std::string wrong_count(std::string_view text) const {
    const auto commas = std::count(text.begin(), text.end(), ',');
    return fmt::format("the row has {} columns, the header {}", commas + 1, names.size());
  }

  std::optional<BadRow> check_time(TraceRow& row) {
    constexpr auto time = static_cast<std::size_t>(Column::time);
    if (!has[time]) {
      if (options.period_s > 0) {
        row.values[time] = static_cast<double>(rows + skipped) * options.period_s;
      }
      return std::nullopt;
    }
    if (!(row.values[time] > last_time_s)) {
      std::size_t column = 0;
      while (targets[column].value != time) {
        ++column;
      }
      return BadRow{
          column, fmt::format("time {} s does not come after {} s", row.values[time], last_time_s)};
    }
    last_time_s = row.values[time];
    return std::nullopt;
  }

  bool next(TraceRow& row) {
    std::string_view text;
    bool complete = false;
    while (next_line(text, complete)) {
      if (text.empty() && complete) {
        continue;
      }
      std::optional<BadRow> bad = parse(text, row);
      if (!bad && !complete) {
        bad = BadRow{names.size() - 1, "the last line has no end; the file seems to be cut off"};
      }
      if (!bad) {
        bad = check_time(row);
      }
      if (!bad) {
        ++rows;
        return true;
      }
      const std::string complaint = files::printable(fmt::format(
          "{}, column {} ({}): {}", place(line), bad->column + 1, names[bad->column], bad->reason));
      if (!options.lenient) {
        fail(complaint);
      }
      complain(complaint);
    }
    // What an MCAP file has before it is cut off is whole: only the rest is lost.
    if (!source->cut_off().empty() && !said_cut_off) {
      said_cut_off = true;
      complain(source->cut_off());
    }
    return false;
  }

  void complain(const std::string& complaint) {
    ++skipped;
    if (complaints.size() < max_complaints) {
      complaints.push_back(complaint);
    }
  }
};

TraceReader::TraceReader(const std::string& path, TraceOptions options)
    : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  impl_->options = std::move(options);
  impl_->open_file();
  impl_->read_header();
}
TraceReader::~TraceReader() = default;
TraceReader::TraceReader(TraceReader&&) noexcept = default;
TraceReader& TraceReader::operator=(TraceReader&&) noexcept = default;

bool TraceReader::timed() const {
  return has(Column::time) || impl_->options.period_s > 0;
}
bool TraceReader::has(Column column) const {
  return impl_->has[static_cast<std::size_t>(column)];
}
const std::vector<std::string>& TraceReader::names() const {
  return impl_->names;
}
const std::vector<std::size_t>& TraceReader::unknown() const {
  return impl_->unknown;
}
bool TraceReader::next(TraceRow& row) {
  return impl_->next(row);
}
std::uint64_t TraceReader::rows() const {
  return impl_->rows;
}
std::uint64_t TraceReader::skipped() const {
  return impl_->skipped;
}
std::uint64_t TraceReader::bytes() const {
  return impl_->source->bytes();
}
std::uint64_t TraceReader::file_size() const {
  return impl_->source->size();
}
const std::vector<std::string>& TraceReader::complaints() const {
  return impl_->complaints;
}

}  // namespace smaservo::hal
