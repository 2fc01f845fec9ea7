#pragma once
// The estimation loop on a recorded trace.

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/replay/trace.hpp"
#include "host-sim/replay/error_statistics.hpp"
#include "host-sim/replay/measurement_params.hpp"
#include "host-sim/report/series.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::replay {

struct ReplayOptions {
  std::string trace;  ///< path, "-" for standard input
  hal::TraceOptions trace_options;
  files::WireDescription wire;
  std::vector<std::string> observers{"kalman"};  ///< the first one writes `out` and the plots, the
                                                 ///< others run where there is a reference
  std::vector<files::Override> settings;         ///< of observer and measurement
  std::optional<double> load_N;                  ///< where the trace has neither load nor stress
  std::optional<double> stress_Pa;
  std::optional<double> ambient_K;   ///< first guess; none: the trace's first value, or 25 °C
  std::vector<std::string> allowed;  ///< checks of the trace that may fail
  std::string out;                   ///< CSV, "-" for standard output; empty: none
};

struct ObserverResult {
  std::string name;
  ErrorStatistics error;  ///< in per cent of the nominal stroke
  bool lost = false;      ///< an error was above 20 %, later than a second after a start
};

/// What the values of a column of the estimate were, in the unit of its name.
struct ColumnSummary {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
  double sum = 0;
  std::uint64_t count = 0;
  std::uint64_t empty = 0;  ///< rows without a value

  void add(double value);
  double mean() const { return sum / static_cast<double>(count); }
};
inline constexpr std::array<std::string_view, 4> summarized_columns{
    "strain", "wire_temperature_degC", "martensite", "resistance_ohm"};

struct ReplayResult {
  bool open_loop = false;  ///< the trace has temperature and stress instead of voltage and current
  bool timed = false;      ///< rows have a time
  bool has_reference = false;
  std::vector<ObserverResult> observers;
  std::uint64_t rows = 0;
  std::uint64_t skipped = 0;
  std::uint64_t invalid = 0;   ///< rows without a valid resistance
  std::uint64_t restarts = 0;  ///< after gaps of more than a minute, and with each new piece of the
                               ///< trace: what happened there is unknown
  std::uint64_t bytes = 0;
  std::vector<std::string> complaints, clock_notes;
  double duration_s = 0;
  double elapsed_s = 0;
  std::array<ColumnSummary, summarized_columns.size()> columns;  ///< in the order of their names
  report::ReplaySeries series;
};

/// Throws UserError, TraceError; UserError also where the trace shows a mistake
/// (host-sim/checks/findings.hpp) that is not allowed, or has no valid resistance at all.
ReplayResult replay(const ReplayOptions& options);

}  // namespace smaservo::replay
