#include "host-sim/inspect/inspect.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "host-sim/checks/statistics.hpp"

namespace smaservo::inspect {
namespace {

using checks::Record;
using checks::RunKind;
using hal::Column;

constexpr std::size_t most_rows = std::size_t{1} << 20;
constexpr double heats_W_m = 0.1;  ///< still air removes 0.04 to 0.07 W/mK from any thin wire

/// The columns that mean something, in the order of the reader's own.
constexpr auto shown =
    std::to_array<std::pair<Column, std::string_view>>({{Column::time, "time"},
                                                        {Column::current, "current"},
                                                        {Column::voltage, "voltage"},
                                                        {Column::load, "load"},
                                                        {Column::stress, "stress"},
                                                        {Column::temperature, "temperature"},
                                                        {Column::ambient, "ambient"},
                                                        {Column::strain_ref, "strain_ref"},
                                                        {Column::displacement, "displacement"},
                                                        {Column::resistance, "resistance"},
                                                        {Column::power, "power"},
                                                        {Column::heating, "power"}});

/// The values of each column in the unit of the file.
class Ranges {
 public:
  explicit Ranges(const hal::TraceReader& trace) : trace_(&trace) {
    for (const auto& [column, name] : shown) {
      if (trace.has(column) && !(column == Column::voltage && is_derived())) {
        columns_.push_back(column);
        values_.emplace_back();
      }
    }
    others_.resize(trace.unknown().size());
  }

  void add(const hal::TraceRow& row) {
    for (std::size_t k = 0; k < columns_.size() && values_[k].size() < most_rows; ++k) {
      values_[k].push_back(row[columns_[k]]);
    }
    std::string_view rest = row.text;
    std::size_t at = 0;
    for (std::size_t k = 0; k < others_.size() && others_[k].size() < most_rows; ++k) {
      for (; at < trace_->unknown()[k]; ++at) {
        rest.remove_prefix(std::min(rest.find(','), rest.size() - 1) + 1);
      }
      others_[k].push_back(number(rest.substr(0, rest.find(','))));
    }
  }

  std::vector<ColumnFacts> facts() const {
    std::vector<ColumnFacts> all;
    for (const std::string& name : trace_->names()) {
      all.push_back({name, "", "", false, 0, 0, 0});
    }
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const std::size_t position = trace_->position(columns_[k]);
      const std::string own = trace_->own_name(position);
      const auto* const known =
          std::ranges::find(shown, columns_[k], &std::pair<Column, std::string_view>::first);
      ColumnFacts& facts = all.at(position);
      facts.is_number = true;
      facts.meaning = known->second;
      facts.unit = own.substr(std::min(known->second.size() + 1, own.size()));
      const auto in_file = [&](double si) { return trace_->in_unit(columns_[k], si); };
      const auto [low, high] = std::ranges::minmax(values_[k]);
      facts.low = in_file(low);
      facts.high = in_file(high);
      facts.step = in_file(low + checks::step_of(values_[k])) - in_file(low);
    }
    for (std::size_t k = 0; k < others_.size(); ++k) {
      const std::vector<double> numbers = checks::known(others_[k]);
      if (10 * numbers.size() > 9 * others_[k].size()) {
        ColumnFacts& facts = all.at(trace_->unknown()[k]);
        const auto [low, high] = std::ranges::minmax(numbers);
        facts.is_number = true;
        facts.low = low;
        facts.high = high;
        facts.step = checks::step_of(numbers);
      }
    }
    return all;
  }

 private:
  static double number(std::string_view field) {
    double value = 0;
    const char* const stop = field.data() + field.size();
    // `stop` is where it ends. NOLINTNEXTLINE(bugprone-suspicious-stringview-data-usage)
    const auto [at, error] = std::from_chars(field.data(), stop, value);
    return error == std::errc{} && at == stop ? value : std::numeric_limits<double>::quiet_NaN();
  }
  bool is_derived() const {
    return trace_->has(Column::resistance) &&
           trace_->position(Column::voltage) == trace_->position(Column::resistance);
  }

  const hal::TraceReader* trace_;
  std::vector<Column> columns_;
  std::vector<std::vector<double>> values_;
  std::vector<std::vector<double>> others_;  ///< of the columns that are not understood
};

RunKind kind_of(const Record& record, const Geometry<double>& geometry) {
  double most_W = 0;
  for (std::size_t i = 0; i < std::min(record.current_A.size(), record.voltage_V.size()); ++i) {
    most_W = std::max(most_W, std::abs(record.current_A[i] * record.voltage_V[i]));
  }
  const bool heated = most_W > heats_W_m * geometry.length_m;
  if (!record.power_W_kg.empty() && !record.temperature_K.empty()) {
    return RunKind::calorimetry;
  }
  if (!record.temperature_K.empty() && !heated) {
    return RunKind::bath;
  }
  return record.time_s.empty() ? RunKind::settled : RunKind::joule;
}

/// The steps between the rows.
class Times {
 public:
  void add(const hal::TraceRow& row) {
    const double time_s = row[Column::time];
    if (std::isnan(first_s_)) {
      first_s_ = time_s;
    } else if (steps_.size() < most_rows) {
      steps_.push_back(time_s - last_s_);
      if (steps_.back() > longest_s_) {
        longest_s_ = steps_.back();
        longest_line_ = row.line;
      }
    }
    last_s_ = time_s;
  }

  void tell(std::string_view line_word, Facts& facts) {
    if (steps_.empty()) {
      return;
    }
    std::ranges::sort(steps_);
    const auto at = [&](double share) {
      return steps_[static_cast<std::size_t>(share * static_cast<double>(steps_.size() - 1))];
    };
    facts.duration_s = last_s_ - first_s_;
    facts.longest_s = longest_s_;
    facts.longest_at = fmt::format("{} {}", line_word, longest_line_);
    facts.step_s = at(0.5);
    // Of a normal distribution two standard deviations.
    facts.jitter_s = (at(0.84) - at(0.16)) / 2;
    facts.gaps = static_cast<std::uint64_t>(
        std::ranges::count_if(steps_, [&](double step) { return step > 3 * facts.step_s; }));
  }

 private:
  double first_s_ = std::numeric_limits<double>::quiet_NaN(), last_s_ = first_s_;
  double longest_s_ = 0;
  std::uint64_t longest_line_ = 0;
  std::vector<double> steps_;
};

/// Counts how often the wire was heated to at least half of what it was heated to at most, and
/// cooled again to a quarter; and the levels of stress during these.
void find_heatings(const Record& record, const Geometry<double>& geometry, Facts& facts) {
  const std::vector<double> heating = checks::heating_K(record, geometry);
  if (heating.empty() || record.kind == RunKind::settled) {
    return;
  }
  const auto [coldest, hottest] = std::ranges::minmax(heating);
  if (!(hottest - coldest > 10)) {
    return;
  }
  std::vector<double> levels;
  bool hot = false;
  for (std::size_t i = 0; i < heating.size(); ++i) {
    const double share = (heating[i] - coldest) / (hottest - coldest);
    if (!hot && share > 0.5) {
      hot = true;
      ++facts.heatings;
      if (i < record.stress_Pa.size()) {
        levels.push_back(1e-6 * record.stress_Pa[i]);
      }
    }
    hot = hot && share > 0.25;
  }
  std::ranges::sort(levels);
  constexpr double same_MPa = 10;
  for (const double level : levels) {
    if (facts.loads_MPa.empty() || level > facts.loads_MPa.back() + same_MPa) {
      facts.loads_MPa.push_back(level);
    }
  }
}

std::string quoted(const std::string& path) {
  const bool plain = std::ranges::all_of(path, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string("._-/+=:").find(c) != std::string::npos;
  });
  if (plain && !path.empty()) {
    return path;
  }
  std::string text = "'";
  for (const char c : path) {
    text += c == '\'' ? "'\\''" : std::string(1, c);
  }
  return text + "'";
}

std::string words_of(const InspectOptions& options, bool has_bad_rows) {
  std::string words = options.wire_words;
  for (const std::string& rename : options.trace_options.renames) {
    words += " --column " + quoted(rename);
  }
  if (has_bad_rows) {
    words += " --lenient";
  }
  if (options.trace_options.period_s > 0) {
    words += fmt::format(" --period-s {}", options.trace_options.period_s);
  }
  return words;
}

std::string missing(const Record& record) {
  std::string text;
  const auto need = [&](bool there, const char* what) {
    text += there ? "" : (text.empty() ? "" : ", ") + std::string(what);
  };
  need(!record.time_s.empty(), "a time (or --period-s)");
  need(!record.current_A.empty(), "a current");
  need(!record.voltage_V.empty(), "a voltage or resistance");
  return text;
}

/// What identify() can make of a record.
struct Fits {
  bool fits;
  std::string command;  ///< beside the file and --out
  std::string note;     ///< what it lacks, or what to know
};
Fits fits_of(const Record& record, const std::string& lacks, bool has_load, std::size_t loads) {
  if (record.kind == RunKind::calorimetry) {
    return {true, "", ""};
  }
  const bool bath = record.kind == RunKind::bath;
  if (record.strain.empty() && !(bath && !record.resistance_ohm.empty())) {
    return {false, "", "needs a displacement or strain_ref"};
  }
  const std::string load = has_load ? "" : " --load-N N";
  if (!record.heating_W.empty() && !record.time_s.empty() && !bath) {
    return {true, load, has_load ? "add --imposed-strain if a test frame set the strain" : ""};
  }
  if (!bath && !lacks.empty()) {
    return {false, "", "needs " + lacks};
  }
  return {true, load,
          loads < 3 && record.kind == RunKind::joule
              ? "runs under three loads tell more; host-sim calibrate-plan says which"
              : ""};
}

void find_uses(const InspectOptions& options, Facts& facts) {
  const Record& record = facts.record;
  const std::string words = words_of(options, facts.bad_rows > 0);
  const std::string file = quoted(options.trace);
  const bool has_load = !record.stress_Pa.empty();
  const std::string lacks = record.kind == RunKind::bath ? "" : missing(record);
  facts.uses.push_back({"replay",
                        lacks.empty() ? fmt::format("host-sim replay{}{} --report report.html {}",
                                                    words, has_load ? "" : " --load-N N", file)
                                      : "",
                        lacks.empty() ? has_load ? "" : "the file has no load" : "needs " + lacks});
  const Fits fits = fits_of(record, lacks, has_load, facts.loads_MPa.size());
  const std::string from = words.starts_with(" --wire ") ? " --from" + words.substr(7) : words;
  facts.uses.push_back(
      {"identify",
       fits.fits ? fmt::format("host-sim identify{}{} --out mine.toml {}", from, fits.command, file)
                 : "",
       fits.note});
}

}  // namespace

Facts inspect(const InspectOptions& options) {
  hal::TraceOptions trace_options = options.trace_options;
  trace_options.resistance_and_power = true;
  trace_options.lenient = true;
  hal::TraceReader trace(options.trace, trace_options);
  Facts facts;
  facts.name = options.trace == "-" ? "standard input" : options.trace;
  facts.read_as = trace.read_as();
  facts.hints = trace.hints();
  facts.timed = trace.timed();
  checks::Recorder recorder(trace, most_rows);
  Ranges ranges(trace);
  Times times;
  hal::TraceRow row{};
  while (trace.next(row)) {
    recorder.add(row);
    ranges.add(row);
    if (trace.timed()) {
      times.add(row);
    }
  }
  facts.rows = trace.rows();
  facts.bad_rows = trace.skipped();
  if (facts.rows == 0) {
    throw hal::TraceError(fmt::format("{}: has no usable row", facts.name));
  }
  facts.skipped = trace.complaints();
  for (const std::string& note : trace.clock_notes()) {
    facts.skipped.push_back(note);
  }
  if (trace.repeated_headers() > 0) {
    facts.skipped.push_back(fmt::format("{} times the header again", trace.repeated_headers()));
  }
  if (trace.strays() > 0) {
    facts.skipped.push_back(
        fmt::format("{} lines that are no rows; {}", trace.strays(), trace.first_stray()));
  }
  const Geometry<double>& geometry = options.wire.wire.geometry;
  facts.columns = ranges.facts();
  if (std::ranges::none_of(facts.columns, &ColumnFacts::is_number)) {
    throw hal::TraceError(
        fmt::format("{}: no column has numbers; is it a table of measurements?", facts.name));
  }
  facts.record = recorder.finish(facts.name, geometry);
  Record& record = facts.record;
  record.kind = kind_of(record, geometry);
  times.tell(trace.word(), facts);
  facts.resistances = checks::known(record.resistance_ohm).size();
  const checks::Range ohm = checks::range_of(record.resistance_ohm);
  facts.ohm_low = ohm.low;
  facts.ohm_high = ohm.high;
  find_heatings(record, geometry, facts);
  facts.findings = checks::find_mistakes(record, {geometry});
  if (!options.wire_given) {
    // What needs the wire's length or diameter cannot be judged.
    std::erase_if(facts.findings, [](const checks::Finding& finding) {
      return finding.check != "direction" && finding.check != "clipped" &&
             finding.check != "sampling" && finding.check != "temperature";
    });
  }
  find_uses(options, facts);
  return facts;
}

}  // namespace smaservo::inspect
