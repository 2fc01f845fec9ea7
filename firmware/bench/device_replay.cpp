#include "firmware/bench/device_replay.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>

#include "firmware/cycle.hpp"
#include "firmware/device/adopt.hpp"
#include "firmware/text/device_log.hpp"
#include "firmware/text/device_trace.hpp"
#include "firmware/text/signal_names.hpp"
#include "hal/replay/board.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/progress.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::bench {
namespace {

/// The number, if the whole text is a finite one, else nullopt.
std::optional<double> number_in(std::string_view text) {
  double value = 0;
  const char* const begin = text.data();
  const char* const stop = begin + text.size();
  const auto [at, error] = std::from_chars(begin, stop, value);
  const bool whole = error == std::errc{} && at == stop && std::isfinite(value);
  return whole ? std::optional(value) : std::nullopt;
}

/// Compares the outputs with those in the trace.
class Comparison {
 public:
  Comparison(const std::vector<std::string>& names, double tolerance) : tolerance_(tolerance) {
    for (const text::DeviceColumn& column : text::output_columns()) {
      const auto found = std::ranges::find(names, column.name);
      if (found != names.end()) {
        pairs_.push_back({column, static_cast<std::size_t>(found - names.begin())});
        pairs_.back().difference.column = column.name;
      }
    }
  }

  void add(const Cycle& cycle, const std::vector<std::string_view>& fields) {
    bool differs = false;
    for (Pair& pair : pairs_) {
      now_.clear();
      pair.column.write(now_, cycle);
      const std::string_view recorded = fields.at(pair.position);
      if (now_ != recorded) {
        differs = true;
        note(pair, recorded, cycle.time_s);
      }
      if (tolerance_ > 0) {
        pair.span(recorded);
      }
    }
    differing_rows_ += differs ? 1U : 0U;
  }

  void finish(DeviceReplayResult& result) {
    result.differing_rows = differing_rows_;
    for (Pair& pair : pairs_) {
      OutputDifference& difference = pair.difference;
      result.compared.push_back(difference.column);
      if (difference.rows > 0) {
        difference.tolerated =
            tolerance_ > 0 && pair.numbers && difference.max <= tolerance_ * (pair.max - pair.min);
        result.differences.push_back(difference);
      }
    }
  }

 private:
  struct Pair {
    text::DeviceColumn column;
    std::size_t position;
    OutputDifference difference{};
    bool numbers = true;  // whether all that differ are numbers
    double min = std::numeric_limits<double>::infinity();
    double max = -min;

    void span(std::string_view recorded) {
      if (const std::optional<double> value = number_in(recorded)) {
        min = std::min(min, *value);
        max = std::max(max, *value);
      }
    }
  };

  void note(Pair& pair, std::string_view recorded, double time_s) const {
    OutputDifference& difference = pair.difference;
    if (difference.rows++ == 0) {
      difference.first_s = time_s;
      difference.recorded = recorded;
      difference.now = now_;
    }
    const std::optional<double> before = number_in(recorded);
    const std::optional<double> now = number_in(now_);
    if (before && now) {
      difference.max = std::max(difference.max, std::abs(*before - *now));
    } else {
      pair.numbers = false;
    }
  }

  double tolerance_;
  std::vector<Pair> pairs_;
  std::string now_;
  std::uint64_t differing_rows_ = 0;
};

/// Gives the columns of an older log the names of today, and says which.
std::vector<std::string> renamed_columns(std::vector<std::string>& names) {
  std::vector<std::string> said;
  for (const text::DeviceColumn& column : text::output_columns()) {
    const std::string_view former = text::former_column(column.name);
    const auto found = std::ranges::find(names, former);
    if (!former.empty() && found != names.end() &&
        std::ranges::find(names, column.name) == names.end()) {
      said.push_back(fmt::format("{} is now called {}", former, column.name));
      *found = column.name;
    }
  }
  return said;
}

/// The file that the replay writes: the log and the outputs, then the trace's other columns.
class ReplayFile {
 public:
  /// `names` are those of the trace's columns.
  ReplayFile(const std::string& path, const std::string& source, const hal::TraceReader& trace,
             const std::vector<std::string>& names) {
    std::vector<text::DeviceColumn> columns =
        text::log_columns(trace.has(hal::Column::supply), trace.has(hal::Column::ambient),
                          trace.has(hal::Column::driver));
    columns.insert(columns.end(), text::output_columns().begin(), text::output_columns().end());
    std::vector<std::string> further;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string& name = names[i];
      if (std::ranges::find(columns, name, &text::DeviceColumn::name) == columns.end()) {
        positions_.push_back(i);
        further.push_back(name);
      }
    }
    file_ = std::make_unique<text::DeviceTraceFile>(
        path, hal::mcap::Origin{"host-sim replay-device", source}, std::move(columns), further);
  }

  void add(const Cycle& cycle, const std::vector<std::string_view>& fields) {
    further_.clear();
    for (const std::size_t position : positions_) {
      further_ += ',';
      further_ += fields.at(position);
    }
    file_->add(cycle, further_);
  }
  void commit() { file_->commit(); }

 private:
  std::vector<std::size_t> positions_;
  std::string further_;
  std::unique_ptr<text::DeviceTraceFile> file_;
};

/// Longer steps are those after a stall, of which the recording says so itself.
double step_s(const std::string& trace, double from_s, std::int64_t from_ns, std::int64_t to_ns,
              FaultSet external) {
  const std::int64_t step_ns = to_ns - from_ns;
  const double dt_s = static_cast<double>(step_ns) * 1e-9;
  const std::int64_t longest_ns =
      external.has(Fault::loop_stalled) ? longest_stall_ns : longest_step_ns;
  if (step_ns < shortest_step_ns || longest_ns < step_ns) {
    throw files::UserError(
        fmt::format("{}: the row after {} s comes {} s later; a device steps every {} to {} s, "
                    "unless external_faults says loop_stalled",
                    trace, from_s, dt_s, static_cast<double>(shortest_step_ns) / 1e9,
                    static_cast<double>(longest_step_ns) / 1e9));
  }
  return dt_s;
}

void change_parameters(const text::DeviceLog& log, const std::vector<std::string_view>& fields,
                       double time_s, Prepared<double>& prepared, Device<double>::State& device) {
  Settings<double> settings = prepared.settings;
  if (log.change(fields, time_s, settings)) {
    adopt(prepared, settings, device);
  }
}

}  // namespace

DeviceReplayResult replay_device(const DeviceReplayOptions& options) {
  hal::TraceOptions trace_options = options.trace_options;
  trace_options.device = true;
  hal::TraceReader reader(options.trace, trace_options);
  std::vector<std::string> names = reader.names();
  DeviceReplayResult result;
  result.renamed = renamed_columns(names);
  const text::DeviceLog log(options.trace, names);
  Comparison comparison(names, options.tolerance);
  std::unique_ptr<ReplayFile> file;
  if (!options.out.empty()) {
    file = std::make_unique<ReplayFile>(options.out, options.trace, reader, names);
  }
  files::Progress progress("replay", reader.file_size());
  hal::ReplayBoard board(std::move(reader), std::numeric_limits<double>::quiet_NaN(),
                         options.settings.wire.geometry.area_m2());
  const auto prepared = std::make_unique<Prepared<double>>(prepare(options.settings));
  Device<double>::State device = Device<double>::start();
  std::vector<std::string_view> fields;
  Cycle cycle{};
  hal::Frame frame{};
  std::int64_t last_ns = 0;
  for (hal::ReadStatus status = board.read(frame); status != hal::ReadStatus::end;
       status = board.read(frame)) {
    const double before_s = cycle.time_s;
    cycle.time_s = static_cast<double>(frame.time_ns) / 1e9;
    text::split_fields(board.row().text, fields);
    const Heard<double> heard = log.heard(fields, cycle.time_s);
    const double dt_s =
        result.rows == 0 ? options.settings.timing.period_s
                         : step_s(options.trace, before_s, last_ns, frame.time_ns, heard.external);
    last_ns = frame.time_ns;
    change_parameters(log, fields, cycle.time_s, *prepared, device);
    run_cycle(board, frame, status, heard, 0, cycle,
              [&](const Inputs<double>& in, const Command<double>& command) {
                return Device<double>::step(*prepared, device, in, command, dt_s);
              });
    comparison.add(cycle, fields);
    if (file) {
      file->add(cycle, fields);
    }
    result.duration_s += result.rows == 0 ? 0 : dt_s;
    ++result.rows;
    progress.update(board.trace().bytes());
  }
  if (result.rows == 0) {
    throw files::UserError(fmt::format("{}: has no usable row", options.trace));
  }
  result.skipped = board.trace().skipped();
  result.complaints = board.trace().complaints();
  comparison.finish(result);
  if (file) {
    file->commit();
  }
  return result;
}

bool agrees(const DeviceReplayResult& result) {
  return std::ranges::all_of(result.differences, &OutputDifference::tolerated);
}

std::string summary(const DeviceReplayOptions& options, const DeviceReplayResult& result) {
  std::string text =
      fmt::format("{}: {} rows, {:.4g} s\n",
                  options.trace == "-" ? "standard input" : files::printable(options.trace),
                  result.rows, result.duration_s);
  for (const std::string& renamed : result.renamed) {
    text += fmt::format("column {}\n", renamed);
  }
  if (result.skipped > 0) {
    text += fmt::format("{} bad rows skipped\n", result.skipped);
    for (const std::string& complaint : result.complaints) {
      text += fmt::format("  skipped: {}\n", complaint);
    }
  }
  if (result.compared.empty()) {
    return text + "the trace has no outputs to compare with\n";
  }
  if (result.differing_rows == 0) {
    return text +
           fmt::format("all {} outputs are the same to the last bit\n", result.compared.size());
  }
  text += fmt::format("{} rows differ from the outputs in the trace\n", result.differing_rows);
  files::TextTable table({{"output"},
                          {"rows", "{}"},
                          {"first at s", "{:.6g}"},
                          {"max difference", "{:.4g}"},
                          {"first difference: in the trace, now"}});
  for (const OutputDifference& d : result.differences) {
    table.add({d.column, d.rows, d.first_s, d.max,
               fmt::format("'{}', '{}'{}", d.recorded, d.now, d.tolerated ? ", tolerated" : "")});
  }
  return text + table.text();
}

}  // namespace smaservo::bench
