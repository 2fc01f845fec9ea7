#pragma once
// The rows of the table: the runs of each, and the figures of these runs together.

#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "host-sim/evaluate/judge.hpp"
#include "host-sim/evaluate/runs/runs.hpp"

namespace smaservo::evaluate {

enum class Disturbed : unsigned char { never, always, every_other };

/// Targets are in % of the stroke; NaN where there is none.
struct EvaluationRow {
  std::string_view name;
  std::string_view meaning;
  std::vector<Condition> conditions;  ///< in turn
  Disturbed disturbed = Disturbed::never;
  bool calibrated =
      true;        ///< by identification; otherwise the type file and a one-point resistance
  int runs = 108;  ///< of all units together, unless the options say otherwise
  double mean = std::numeric_limits<double>::quiet_NaN();
  double p95 = std::numeric_limits<double>::quiet_NaN();
  double maximum = std::numeric_limits<double>::quiet_NaN();
};

/// "standard", "disturbed", "light", "uncalibrated", "unknown-start", "hold", "coarse".
const std::vector<EvaluationRow>& evaluation_rows();

/// What identifies a run: test_run(random_unit(family, unit), ...) makes it again.
struct EvaluatedRun {
  hal::Family family;
  std::uint64_t unit;
  Condition condition;
  bool disturbed;
  std::uint64_t seed;
};

/// The figures of an observer in that run.
struct JudgedRun {
  EvaluatedRun run;
  RunFigures figures;
  double drift_percent = std::numeric_limits<double>::quiet_NaN();  ///< of hold_ripple
  std::optional<StartFigures> start;                                ///< of unknown_start
};

/// Runs that are counted together.
struct RowFigures {
  int runs = 0;
  replay::ErrorStatistics
      error;  ///< of all instants after the first second of each run, in % of the stroke
  int lost = 0;
  double within_2_sd;  ///< share of these instants; NaN where an observer has no deviation
  // Magnitudes of the drifts; NaN in rows without a drift.
  double drift_mean, drift_p95, drift_maximum;
  // NaN in rows without unknown starts.
  double found_median_s, found_p90_s;
  int locked = 0, unsure = 0;
};
RowFigures together(const std::vector<JudgedRun>& runs);

}  // namespace smaservo::evaluate
