#include "hal/replay/trace.hpp"

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <optional>

#include "hal/replay/time_repair.hpp"
#include "hal/replay/trace_columns.hpp"
#include "hal/replay/trace_text.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::hal {
namespace {

constexpr std::size_t buffer_size = std::size_t{1} << 20;
constexpr std::size_t max_complaints = 10;

}  // namespace

struct TraceReader::Impl {
  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() = default;

  std::string path;
  TraceOptions options;
  std::unique_ptr<TraceText> source;
  /// Not set to zero: most files fill a small part of it.
  std::unique_ptr<char[]> buffer = std::make_unique_for_overwrite<char[]>(buffer_size);
  std::size_t begin = 0, end = 0;  ///< unread bytes in the buffer
  bool at_end = false;
  std::uint64_t line = 0, read = 0, rows = 0, skipped = 0, repeated = 0;
  std::string header;
  std::unique_ptr<TraceColumns> columns;
  double last_time_s = -std::numeric_limits<double>::infinity();
  double step_s = 0,
         offset_s = 0;  ///< of a strict reader: the last step; for counters that wrapped
  TimeRepair times;     ///< used by a lenient reader only
  WaitingRow taken{};
  std::vector<std::string> complaints, clock_notes;
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
      std::memmove(buffer.get(), buffer.get() + begin, end - begin);
      end -= begin;
      begin = 0;
    }
    if (end == buffer_size) {
      fail(fmt::format("{}: longer than {} bytes{}", place(line + 1), buffer_size,
                       source->is_mcap() ? "" : "; is this a CSV file?"));
    }
    try {
      const std::size_t got = source->read(buffer.get() + end, buffer_size - end);
      at_end = got == 0;
      end += got;
    } catch (const files::UserError& problem) {
      fail(source->is_mcap() ? problem.what() : place(line + 1) + ": " + problem.what());
    }
  }

  std::string place(std::uint64_t number) const { return source->place(number); }

  /// Reads the next line without its line end; `complete` says whether there was one.
  bool next_line(std::string_view& text, bool& complete) {
    std::size_t searched = begin;
    for (;;) {
      const char* from = buffer.get() + searched;
      const void* found = std::memchr(from, '\n', end - searched);
      if (found != nullptr || (at_end && begin < end)) {
        complete = found != nullptr;
        const char* start = buffer.get() + begin;
        const char* stop = complete ? static_cast<const char*>(found) : buffer.get() + end;
        text = std::string_view(start, static_cast<std::size_t>(stop - start));
        begin = static_cast<std::size_t>(stop - buffer.get()) + (complete ? 1 : 0);
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
    header = text;
    try {
      columns = std::make_unique<TraceColumns>(text, options, place(1), !source->layout().empty());
    } catch (const files::UserError& problem) {
      fail(problem.what());
    }
  }

  bool has_time() const { return columns->has(Column::time); }

  static constexpr const char* counter_goes_on = "; a counter that began at 0 again goes on";
  static std::string falls_back(double time_s, double before_s) {
    return fmt::format("time {} s does not come after {} s", time_s, before_s);
  }

  /// The time must rise, but for a counter of milliseconds or microseconds that wrapped.
  std::optional<BadRow> check_time(TraceRow& row) {
    if (!has_time()) {
      return std::nullopt;
    }
    double& time_s = row.values[static_cast<std::size_t>(Column::time)];
    const double read_s = time_s;
    time_s += offset_s;
    if (!(time_s > last_time_s)) {
      const bool counts = columns->unit(Column::time).suffix != "s";
      const double period_s = counts ? wrap_s(last_time_s, time_s, step_s) : 0;
      BadRow fallen{columns->position(Column::time), falls_back(read_s, last_time_s - offset_s)};
      if (period_s == 0) {
        return fallen;
      }
      offset_s += period_s;
      time_s += period_s;
      if (clock_notes.size() < max_complaints) {
        clock_notes.push_back(complaint_of(line, {fallen.column, fallen.reason + counter_goes_on}));
      }
    }
    step_s = time_s - last_time_s;
    last_time_s = time_s;
    return std::nullopt;
  }

  std::string complaint_of(std::uint64_t at, const BadRow& bad) const {
    return files::printable(fmt::format("{}, column {} ({}): {}", place(at), bad.column + 1,
                                        columns->names()[bad.column], bad.reason));
  }

  /// Reads the next row that is valid by itself, whatever the times of the other rows are.
  bool next_by_itself(TraceRow& row) {
    std::string_view text;
    bool complete = false;
    while (next_line(text, complete)) {
      if (text.empty() && complete) {
        continue;
      }
      std::optional<BadRow> bad = columns->parse(text, row);
      row.number = read++;
      row.line = source->number(line);
      row.piece = 0;
      if (bad && text == header) {
        ++repeated;  // a logger that was restarted writes it again
        --read;
        continue;
      }
      if (bad && !complete) {
        // Whatever wrote the file was stopped in the middle of a line.
        bad->reason += "; the last line has no end, so the file was cut off there";
        complain(complaint_of(line, *bad));
        return false;
      }
      if (!has_time() && options.period_s > 0) {
        row.values[static_cast<std::size_t>(Column::time)] =
            static_cast<double>(row.number) * options.period_s;
      }
      if (!bad && !options.lenient) {
        bad = check_time(row);
      }
      if (!bad) {
        return true;
      }
      refuse(complaint_of(line, *bad));
    }
    return false;
  }

  static std::string said_of(const TimeRepair::Taken& how) {
    switch (how.verdict) {
      case TimeRepair::Verdict::late:
        return fmt::format("time {} s does not come before {} s", how.read_s, how.other_s);
      case TimeRepair::Verdict::wraps:
        return falls_back(how.read_s, how.other_s) + counter_goes_on;
      case TimeRepair::Verdict::begins:
        return falls_back(how.read_s, how.other_s) +
               "; the clock began anew, and with it a new piece";
      default:
        return falls_back(how.read_s, how.other_s);
    }
  }

  /// Like next_by_itself(), with times that TimeRepair has made rise.
  bool next_in_time(TraceRow& row) {
    for (;;) {
      WaitingRow further{};
      while (times.waiting() < TimeRepair::judged_with && next_by_itself(further.row)) {
        further.text = further.row.text;
        further.line = line;
        times.add(std::move(further));
        further = {};
      }
      if (times.waiting() == 0) {
        return false;
      }
      const TimeRepair::Taken how = times.take(taken);
      if (how.verdict != TimeRepair::Verdict::rises) {
        const std::string said =
            complaint_of(taken.line, {columns->position(Column::time), said_of(how)});
        if (how.verdict == TimeRepair::Verdict::early || how.verdict == TimeRepair::Verdict::late) {
          refuse(said);
          continue;
        }
        if (clock_notes.size() < max_complaints) {
          clock_notes.push_back(said);
        }
      }
      row = taken.row;
      row.text = taken.text;
      return true;
    }
  }

  bool next(TraceRow& row) {
    const bool in_time = options.lenient && has_time();
    if (in_time ? next_in_time(row) : next_by_itself(row)) {
      ++rows;
      return true;
    }
    // An MCAP file that was cut off is complete up to there: only the rest is lost.
    if (!source->cut_off().empty() && !said_cut_off) {
      said_cut_off = true;
      complain(source->cut_off());
    }
    if (source->strays() > rows) {
      fail(fmt::format("{} of {} lines are no rows, more than half; {}", source->strays(),
                       source->strays() + rows, files::printable(source->first_stray())));
    }
    if (options.lenient && skipped > rows) {
      throw TraceError(fmt::format("{}: {} of {} rows are bad, more than half; {}", path, skipped,
                                   skipped + rows, complaints.front()));
    }
    return false;
  }

  /// Handles a bad row: throws, unless the reader is lenient.
  void refuse(const std::string& complaint) {
    if (!options.lenient) {
      fail(complaint);
    }
    complain(complaint);
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
  return impl_->columns->has(column);
}
std::size_t TraceReader::position(Column column) const {
  return impl_->columns->position(column);
}
const std::string& TraceReader::name(Column column) const {
  return impl_->columns->names().at(impl_->columns->position(column));
}
const std::vector<std::string>& TraceReader::names() const {
  return impl_->columns->names();
}
std::string TraceReader::own_name(std::size_t column) const {
  return impl_->columns->own_name(column);
}
double TraceReader::scale(std::size_t column) const {
  return impl_->columns->scale(column);
}
double TraceReader::in_unit(Column column, double si) const {
  return impl_->columns->unit(column).from_si(si);
}
const std::vector<std::size_t>& TraceReader::unknown() const {
  return impl_->columns->unknown();
}
std::string_view TraceReader::word() const {
  return impl_->source->word();
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
std::uint64_t TraceReader::repeated_headers() const {
  return impl_->repeated + impl_->source->repeated_headers();
}
std::uint64_t TraceReader::strays() const {
  return impl_->source->strays();
}
std::string TraceReader::first_stray() const {
  return impl_->source->first_stray();
}
std::string TraceReader::read_as() const {
  const std::string layout = impl_->source->layout();
  const std::string& columns = impl_->columns->recognised();
  return layout + (layout.empty() || columns.empty() ? "" : "; ") + columns;
}
bool TraceReader::is_packed() const {
  return impl_->source->is_packed();
}
const std::vector<std::string>& TraceReader::hints() const {
  return impl_->columns->hints();
}
const std::vector<std::string>& TraceReader::clock_notes() const {
  return impl_->clock_notes;
}

}  // namespace smaservo::hal
