#pragma once
// The table by which observers are judged: many simulated runs of units that differ from the
// observers' model, in rows of conditions, each with a target.

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host-sim/evaluate/rows.hpp"
#include "host-sim/identify/fit/fit.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::evaluate {

/// First seed of units for tests; observers are tuned with the seeds 1 to 99.
inline constexpr std::uint64_t first_test_seed = 1000;

struct EvaluateOptions {
  std::vector<hal::Family> families{hal::tuning_families.begin(), hal::tuning_families.end()};
  int units = 3;  ///< units of each family, with seeds from `seed` on
  int runs = 0;   ///< runs in each row; 0: as many for each unit as the row says
  std::uint64_t seed = first_test_seed;
  int threads = 1;  ///< does not affect the result
  std::vector<std::string> observers{"kalman"};
  std::vector<std::string> programs;      ///< paths of observers that are programs (README.md)
  std::vector<files::Override> settings;  ///< overrides of settings of observers and measurement
  std::vector<std::string> rows;          ///< names of rows; none: all
  /// Folder of the calibrated wires, created if it is missing. A unit whose file (calibrated_name)
  /// is there is not calibrated again. Empty: nothing is kept.
  std::string wires;
  identify::Structure structure = identify::Structure::automatic;  ///< of the calibrations
  /// What calibrates a unit instead of calibrated_wire(), if it is set.
  std::function<Wire<double>(const bench::WireUnit&)> calibrated;
  /// Called when a stage begins and after each of its parts, never by two threads at once. What it
  /// throws ends the evaluation.
  std::function<void(std::string_view stage, std::size_t done, std::size_t total)> progress;
};

struct FamilyFigures {
  hal::Family family;
  RowFigures figures;
};

struct RowResult {
  std::size_t row;              ///< index in evaluation_rows()
  std::vector<JudgedRun> runs;  ///< runs of all units in turn, or some that are shown
  RowFigures all;
  std::vector<FamilyFigures> by_family;  ///< in the order of the families in the options
};

/// Adds up the runs of a row, all of them and those of each family.
class RowSum {
 public:
  RowSum(const std::vector<hal::Family>& families, std::size_t row);

  void add(const JudgedRun& run);
  /// With the runs that are shown one by one.
  RowResult result(std::vector<JudgedRun> runs) const;

 private:
  std::size_t row_;
  PooledRuns all_;
  std::vector<std::pair<hal::Family, PooledRuns>> by_family_;
};

struct ObserverEvaluation {
  std::string observer;
  std::vector<RowResult> rows;
};

struct Evaluation {
  double stroke;  ///< nominal stroke, as a strain
  int units;
  std::uint64_t seed;
  /// Observers in the order of the options, then programs. If the row "hold" is evaluated, the
  /// model alone
  /// ("open-loop") is judged in it even if it is not among the options.
  std::vector<ObserverEvaluation> observers;
};

/// Throws UserError for options that are not allowed and for files that cannot be read or written.
/// A run takes about 0.3 s, the calibration of a unit about a minute, on one core.
Evaluation evaluate(const EvaluateOptions& options);

}  // namespace smaservo::evaluate
