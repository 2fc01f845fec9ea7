#include "host-sim/record/run.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>

#include "host-sim/checks/findings.hpp"
#include "host-sim/convert/own_rows.hpp"
#include "host-sim/end_by_signal.hpp"
#include "host-sim/how_read.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::record {
namespace {

using files::UserError;
using hal::Column;

constexpr std::size_t piece_size = std::size_t{1} << 16U;

/// What is compared of a run before and after: all that a command reads of it.
constexpr auto compared =
    std::to_array<Column>({Column::time, Column::current, Column::voltage, Column::load,
                           Column::stress, Column::temperature, Column::ambient, Column::strain_ref,
                           Column::displacement, Column::resistance, Column::power});

hal::TraceOptions options_of(const RunSource& source) {
  hal::TraceOptions options = run_options();
  options.renames = source.renames;
  options.period_s = source.period_s;
  return options;
}

bool has_load(const hal::TraceReader& trace) {
  return trace.has(Column::load) || trace.has(Column::stress);
}

bool has_displacement(const hal::TraceReader& trace) {
  return trace.has(Column::displacement) || trace.has(Column::strain_ref);
}

/// The load of a source without a column of it, as name and text of a column.
std::optional<std::pair<std::string, std::string>> constant_load(const RunSource& source,
                                                                 const Card& card) {
  if (source.stress_MPa) {
    return std::pair<std::string, std::string>("stress_MPa", fmt::format("{}", *source.stress_MPa));
  }
  if (source.load_N) {
    return std::pair<std::string, std::string>("load_N", fmt::format("{}", *source.load_N));
  }
  if (card.number("load.force")) {
    const CardValue& force = card.values.find("load.force")->second;
    return std::pair(force.key.substr(force.key.find('.') + 1).replace(0, 5, "load"),
                     force.written);
  }
  return std::nullopt;
}

/// What the card and the table say of the displacement must agree. "" or what is wrong.
std::string displacement_fault(const hal::TraceReader& trace, const Card& card) {
  const bool none = card.word("displacement.sensor") == "none";
  if (none && has_displacement(trace)) {
    return "has a displacement or strain_ref, and the card says that there is no such sensor: "
           "displacement.sensor = \"none\"";
  }
  return "";
}

/// "" or why the reader, which is strict, has left out rows: the file was cut off.
std::string cut_off(const hal::TraceReader& trace) {
  return trace.skipped() == 0
             ? ""
             : fmt::format("{}; remove what is incomplete at its end", trace.complaints().front());
}

/// A text that was cut off within its last number looks whole.
void say_if_last_line_has_no_end(const RunSource& source, const hal::TraceReader& trace) {
  std::ifstream in(source.path, std::ios::binary | std::ios::ate);
  const bool is_text = !trace.is_packed() && trace.word() == "line";
  // NUL: the second byte of a line end in UTF-16.
  if (is_text && in.seekg(-1, std::ios::end) &&
      std::string_view("\n\r\0", 3).find(static_cast<char>(in.get())) == std::string_view::npos) {
    files::complain("host-sim", fmt::format("{}: its last line has no end; if the file was cut off "
                                            "there, its last number is wrong",
                                            source.shown));
  }
}

/// Makes the file of a run.
class RunWriter {
 public:
  RunWriter(const RunSource& source, const Card& card, const std::string& to)
      : source_(source),
        trace_(source.path, options_of(source)),
        file_(to),
        adds_time_(!trace_.has(Column::time)) {
    say_how_read(source.shown, trace_);
    load_ = has_load(trace_) ? std::nullopt : constant_load(source, card);
    refuse(lacks(trace_, load_.has_value()));
    refuse(displacement_fault(trace_, card));
    if (has_load(trace_) && (source.load_N || source.stress_MPa)) {
      refuse("has a column of the load, so --load-N and --stress-MPa are not for it");
    }
    if (!adds_time_ && source.period_s > 0) {
      refuse("has a time, so --period-s is not for it");
    }
  }

  void write() {
    text_ = convert::own_header(trace_);
    text_ = (adds_time_ ? "time_s," : "") + text_ + (load_ ? "," + load_->first : "") + '\n';
    hal::TraceRow row{};
    while (trace_.next(row)) {
      add(row);
      if (text_.size() >= piece_size) {
        flush();
      }
    }
    refuse(cut_off(trace_));
    refuse(trace_.rows() == 0 ? "has a header and no row" : "");
    flush();
    file_.commit();
    say_what_has_changed();
    say_if_last_line_has_no_end(source_, trace_);
    say_what_was_skipped(source_.shown, trace_);
    for (const std::string& note : trace_.clock_notes()) {
      files::complain("host-sim", fmt::format("{}: {}", source_.shown, note));
    }
  }

 private:
  void refuse(const std::string& fault) const {
    if (!fault.empty()) {
      throw UserError(fmt::format("{}: {}", source_.shown, fault));
    }
  }
  /// The reader of other programs' tables gives commas in texts as semicolons.
  void say_what_has_changed() const {
    if (has_semicolons_ && !trace_.read_as().empty()) {
      files::complain("host-sim", fmt::format("{}: commas in its texts are written as semicolons",
                                              source_.shown));
    }
  }
  void add(const hal::TraceRow& row) {
    const std::size_t begin = text_.size();
    if (adds_time_) {
      text_ += fmt::format("{},", row[Column::time]);
    }
    convert::add_own_row(trace_, row, text_);
    has_semicolons_ |= text_.find(';', begin) != std::string::npos;
    text_ += load_ ? "," + load_->second : "";
    text_ += '\n';
  }
  void flush() {
    file_.write(text_);
    text_.clear();
    refuse_after_signal(source_.shown);
  }

  const RunSource& source_;
  hal::TraceReader trace_;
  files::OutputFile file_;
  std::optional<std::pair<std::string, std::string>> load_;
  bool adds_time_, has_semicolons_ = false;
  std::string text_;
};

std::string name_of(Column column, const hal::TraceReader& trace) {
  return trace.has(column) ? trace.name(column) : "time";
}

/// The same number, to the last bit.
bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) ||
         (std::isnan(a) && std::isnan(b));
}

/// Refuses a copy that does not say what the source says: a name that means something else without
/// --column, a file that was written to meanwhile.
void compare(const RunSource& source, const std::string& copy) {
  hal::TraceReader from(source.path, options_of(source));
  const auto different = [&](const std::string& what) {
    throw UserError(
        fmt::format("{}: {}: cannot be kept without change; rename the column, or repair the file",
                    source.shown, what));
  };
  try {
    hal::TraceReader to(copy, run_options());
    hal::TraceRow a{}, b{};
    while (from.next(a)) {
      if (from.rows() % piece_size == 0) {
        refuse_after_signal(source.shown);
      }
      if (!to.next(b)) {
        different(fmt::format("{} {}: is not read again", from.word(), a.line));
      }
      for (const Column column : compared) {
        const bool is_time = column == Column::time;
        if ((from.has(column) || is_time) && !same(a[column], b[column])) {
          different(fmt::format("{} {}, column '{}': is {} and then {}", from.word(), a.line,
                                name_of(column, from), a[column], b[column]));
        }
      }
    }
    if (to.next(b)) {
      different("has fewer rows than before");
    }
  } catch (const hal::TraceError& error) {
    different(fmt::format("read again: {}", error.what()));
  }
}

inspect::Facts inspected(const std::string& path, const hal::TraceOptions& options,
                         const files::WireDescription& wire) {
  inspect::InspectOptions what;
  what.trace = path;
  what.trace_options = options;
  what.wire = wire;
  what.wire_given = true;
  inspect::Facts facts = inspect::inspect(what);
  facts.record = {};
  return facts;
}

/// What the checks find in the source; the load's checks come from the copy, since there it has
/// one.
std::vector<checks::Finding> findings(const inspect::Facts& source, const inspect::Facts& copy) {
  std::vector<checks::Finding> all = source.findings;
  for (const checks::Finding& finding : copy.findings) {
    const bool is_new = std::ranges::find(all, finding.check, &checks::Finding::check) == all.end();
    if (is_new) {
      all.push_back(finding);
    }
  }
  return all;
}

void judge(const RunSource& source, const std::vector<checks::Finding>& found) {
  std::string error;
  for (const checks::Finding& finding : found) {
    const bool is_allowed =
        std::ranges::find(source.allowed, finding.check) != source.allowed.end();
    std::string text = fmt::format("{}: {}", source.shown, finding.text);
    if (text.find("(--set wire.") != std::string::npos) {
      text += "; here they are those of the card, not of --set";
    }
    if (finding.is_error && !is_allowed && error.empty()) {
      error = fmt::format("{} (to go on all the same: --allow {})", text, finding.check);
    } else {
      files::complain("host-sim", text);
    }
  }
  if (!error.empty()) {
    throw UserError(error);
  }
}

}  // namespace

void refuse_after_signal(const std::string& shown) {
  if (EndBySignal::came()) {
    const std::string said = fmt::format("{}: ended by a signal; nothing is added", shown);
    // The guard ends the program before anybody else can print it.
    files::complain("host-sim", said);
    throw UserError(said);
  }
}

void check_allowed(const std::vector<std::string>& allowed) {
  // Nothing is found in an empty record; only the names are looked at.
  checks::judge_mistakes({}, {}, allowed);
}

std::string lacks(const hal::TraceReader& trace, bool has_constant_load) {
  std::vector<std::string> missing;
  const bool bath = trace.has(Column::temperature) && !trace.has(Column::current);
  if (!trace.timed()) {
    missing.emplace_back("a time (time_s, or --period-s)");
  }
  if (!bath && !trace.has(Column::current)) {
    missing.emplace_back("a current (current_A)");
  }
  if (!bath && !trace.has(Column::voltage)) {
    missing.emplace_back("a voltage (voltage_V) or a resistance (resistance_ohm)");
  }
  if (!has_load(trace) && !has_constant_load) {
    missing.emplace_back(
        "a load (load_N or stress_MPa; where it is constant --load-N, or load.force_N of the "
        "card)");
  }
  return missing.empty()
             ? ""
             : fmt::format("lacks {}; it has the columns: {}; --column says what a column is",
                           fmt::join(missing, ", "), fmt::join(trace.names(), ", "));
}

hal::TraceOptions run_options() {
  hal::TraceOptions options;
  options.resistance_and_power = true;
  return options;
}

inspect::Facts take_run(const RunSource& source, const Card& card,
                        const files::WireDescription& wire, const std::string& to) {
  std::error_code missing;
  if (std::filesystem::exists(source.path, missing) &&
      !std::filesystem::is_regular_file(source.path, missing)) {
    throw UserError(
        fmt::format("{}: is no file; a run is read more than once, so it cannot be a folder, a "
                    "pipe or a device",
                    source.shown));
  }
  RunWriter(source, card, to).write();
  compare(source, to);
  const inspect::Facts before = inspected(source.path, options_of(source), wire);
  inspect::Facts facts = facts_of(to, wire);
  if (const std::string fault = load_fault(facts, card, wire); !fault.empty()) {
    throw UserError(fmt::format("{}: {}", source.shown, fault));
  }
  judge(source, findings(before, facts));
  return facts;
}

inspect::Facts facts_of(const std::string& path, const files::WireDescription& wire) {
  return inspected(path, run_options(), wire);
}

std::string rate_note(const inspect::Facts& facts, const Card& card) {
  const auto rate_Hz = card.number("electronics.rate");
  constexpr double tolerance = 1.05;
  if (!rate_Hz || !(facts.step_s > 0) || 1 <= tolerance * facts.step_s * *rate_Hz) {
    return "";
  }
  return fmt::format("has {:.4g} rows/s, and by the card {:.4g} Hz were converted; one is wrong",
                     1 / facts.step_s, *rate_Hz);
}

std::string load_fault(const inspect::Facts& facts, const Card& card,
                       const files::WireDescription& wire) {
  const auto force_N = card.number("load.force");
  const double area_m2 = wire.wire.geometry.area_m2();
  for (const double load_MPa : facts.loads_MPa) {
    const double load_N = 1e6 * load_MPa * area_m2;
    if (force_N && std::abs(load_N - *force_N) > 0.1 * *force_N) {
      return fmt::format(
          "is heated under a load of {:.4g} N, and by the card load.force is {:.4g} N in all runs; "
          "one is wrong, or the card's must be \"per run\"",
          load_N, *force_N);
    }
  }
  return "";
}

std::string fault_of(const std::string& path, const Card& card) {
  try {
    hal::TraceReader trace(path, run_options());
    if (trace.is_packed() || !trace.read_as().empty()) {
      return fmt::format("{}: is not in this project's columns, as a run is, but {}", path,
                         trace.is_packed() ? "compressed" : trace.read_as());
    }
    if (const std::string missing = lacks(trace, false); !missing.empty()) {
      return fmt::format("{}: {}", path, missing);
    }
    if (const std::string fault = displacement_fault(trace, card); !fault.empty()) {
      return fmt::format("{}: {}", path, fault);
    }
    hal::TraceRow row{};
    while (trace.next(row)) {
    }
    const std::string lost = cut_off(trace);
    return !lost.empty()       ? fmt::format("{}: {}", path, lost)
           : trace.rows() == 0 ? fmt::format("{}: has a header and no row", path)
                               : "";
  } catch (const files::Error& error) {
    return error.what();
  }
}

}  // namespace smaservo::record
