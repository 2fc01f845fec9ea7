#pragma once
// The rows of the table: the runs of each, and the figures of these runs together.

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/evaluate/judge.hpp"
#include "host-sim/evaluate/runs/runs.hpp"

namespace smaservo::evaluate {

enum class Disturbed : unsigned char { never, always, every_other };

/// What is known of a row's wires.
enum class Known : unsigned char {
  type,          ///< the type file, with a resistance measured at one point
  commissioned,  ///< that, and one run without a displacement sensor (host-sim/commission)
  read_stroke,   ///< that, and how far the wire has moved in it from cold to hot
  two_readings,  ///< that, and the wire's length read twice in it, cold and hot
  calibrated     ///< by identification
};

/// Targets are in % of the stroke; NaN if there is none.
struct EvaluationRow {
  std::string_view name;
  std::string_view meaning;
  std::vector<Condition> conditions;  ///< conditions, used in turn
  Disturbed disturbed = Disturbed::never;
  Known known = Known::calibrated;
  Counted counted = Counted::strain;
  int runs = 36;  ///< runs of each unit, unless the options give another number of all
  double mean = std::numeric_limits<double>::quiet_NaN();
  double p95 = std::numeric_limits<double>::quiet_NaN();
  double maximum = std::numeric_limits<double>::quiet_NaN();
};

/// "standard", "disturbed", "light", "uncalibrated", "commissioned", "two-readings",
/// "uncalibrated-stroke", "read-stroke",
/// "unknown-start", "hold", "gust", "coarse".
const std::vector<EvaluationRow>& evaluation_rows();

/// The data that identify a run: test_run(random_unit(family, unit), ...) repeats it.
struct EvaluatedRun {
  hal::Family family;
  std::uint64_t unit;
  Condition condition;
  bool disturbed;
  std::uint64_t seed;
};

/// "ihyp 1000, constant disturbed, seed 100000000"
std::string run_text(const EvaluatedRun& run);

/// The figures of an observer in one run.
struct JudgedRun {
  EvaluatedRun run;
  RunFigures figures;
  /// Drift in the condition hold_ripple.
  double drift_percent = std::numeric_limits<double>::quiet_NaN();
  std::optional<StartFigures> start;  ///< figures of the condition unknown_start
};

/// The figures of several runs together.
struct RowFigures {
  int runs = 0;
  /// Error at all instants after the first second of each run, in % of the stroke.
  replay::ErrorStatistics error;
  int lost = 0;
  /// Share of errors within two deviations; NaN if an observer has no deviation.
  double within_2_sd;
  // Magnitudes of the drifts; NaN in rows without a drift.
  double drift_mean, drift_p95, drift_maximum;
  // NaN in rows without unknown starts.
  double found_median_s, found_p90_s;
  int locked = 0, unsure = 0;
};
/// Runs are added one by one, and not kept.
class PooledRuns {
 public:
  void add(const JudgedRun& run);
  RowFigures figures() const;

 private:
  RowFigures sums_{};
  std::uint64_t with_sd_ = 0, within_2_sd_ = 0;
  std::vector<double> drifts_, found_s_;
};

}  // namespace smaservo::evaluate
