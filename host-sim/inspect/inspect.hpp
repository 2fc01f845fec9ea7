#pragma once
// What a file of measurements holds, and what can be done with it.

#include <cstdint>
#include <string>
#include <vector>

#include "hal/replay/trace.hpp"
#include "host-sim/checks/findings.hpp"
#include "host-sim/units.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::inspect {

struct InspectOptions {
  std::string trace;  ///< path, "-" for standard input
  hal::TraceOptions trace_options;
  files::WireDescription wire;
  /// Whether the wire was named: only then length, diameter, load and power are judged.
  bool wire_given = false;
  /// What the user has typed of it, for the commands that are proposed: "--wire mine.toml".
  std::string wire_words;
};

/// A column of the file.
struct ColumnFacts {
  std::string name;
  std::string meaning;  ///< "current"; empty: kept as text
  std::string unit;     ///< of the numbers below, as in the file
  bool is_number = false;
  double low = 0, high = 0;
  double step = 0;  ///< finest difference of two values
};

/// What the file is good for.
struct Use {
  std::string name;     ///< "replay"
  std::string command;  ///< what to type; empty: it cannot be done
  std::string why;      ///< why not, or what remains to be given
};

struct Facts {
  std::string name;     ///< of the file
  std::string read_as;  ///< how another program's table is laid out; empty: this project's dialect
  std::vector<std::string> hints;
  std::vector<std::string> skipped;  ///< what was left out
  std::uint64_t rows = 0, bad_rows = 0;
  bool timed = false;
  double duration_s = 0;
  double step_s = 0, jitter_s = 0, longest_s = 0;  ///< between rows: middle, spread, longest
  std::string longest_at;                          ///< "line 17"
  std::uint64_t gaps = 0;                          ///< longer than three steps
  std::vector<ColumnFacts> columns;
  std::uint64_t resistances = 0;  ///< rows with enough current for one
  double ohm_low = 0, ohm_high = 0;
  std::uint64_t heatings = 0;
  std::vector<double> loads_MPa;  ///< levels of stress at which the wire was heated
  std::vector<checks::Finding> findings;
  std::vector<Use> uses;
  checks::Record record;  ///< of a million rows
};

/// Reads the file; bad rows are skipped and counted. Throws TraceError for what no command can
/// read.
Facts inspect(const InspectOptions& options);

std::string text_of(const Facts& facts, const InspectOptions& options);
std::string json_of(const std::vector<Facts>& all);
/// A report as one HTML file. Throws UserError.
void write_report(const std::string& path, const Facts& facts, const InspectOptions& options,
                  Units units);

}  // namespace smaservo::inspect
