#pragma once
// The table by which observers are judged: many simulated runs of units that are not the observers'
// model, in rows of conditions, each with a target.

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/evaluate/rows.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::evaluate {

/// Seeds of units are for tests from 1000 on; observers are tuned with 1 to 99.
inline constexpr std::uint64_t first_test_seed = 1000;

struct EvaluateOptions {
  std::vector<hal::Family> families{hal::tuning_families.begin(), hal::tuning_families.end()};
  int units = 3;  ///< of each family, with seeds from `seed` on
  int runs = 0;   ///< of each row; 0: as many as the row has
  std::uint64_t seed = first_test_seed;
  int threads = 1;  ///< the result does not depend on them
  std::vector<std::string> observers{"kalman"};
  std::vector<files::Override> settings;  ///< of observers and measurement
  std::vector<std::string> rows;          ///< names; none: all
  /// Folder of the calibrated wires, made where it is missing. A unit whose file (calibrated_name)
  /// is there is not calibrated again. Empty: nothing is kept.
  std::string wires;
  /// Called after each part of a stage, never from two threads at once.
  std::function<void(std::string_view stage, std::size_t done, std::size_t total)> progress;
};

struct FamilyFigures {
  hal::Family family;
  RowFigures figures;
};

struct RowResult {
  std::size_t row;              ///< of evaluation_rows()
  std::vector<JudgedRun> runs;  ///< units in turn
  RowFigures all;
  std::vector<FamilyFigures> by_family;  ///< in the order of the options
};

struct ObserverEvaluation {
  std::string observer;
  std::vector<RowResult> rows;
};

struct Evaluation {
  double stroke;  ///< the nominal one, as a strain
  int units;
  std::uint64_t seed;
  /// Observers in the order of the options. Where the row "hold" is evaluated, the model alone
  /// ("open-loop") is judged in it even if it is not among the options.
  std::vector<ObserverEvaluation> observers;
};

/// Throws UserError for options that are not allowed and for files that cannot be
/// read or written. A run takes about 0.3 s, the calibration of a unit about a minute, on one core.
Evaluation evaluate(const EvaluateOptions& options);

}  // namespace smaservo::evaluate
