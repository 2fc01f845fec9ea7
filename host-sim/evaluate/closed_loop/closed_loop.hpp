#pragma once
// The table by which control is judged. A unit is a simulated piece of wire that differs from the
// firmware's model. The firmware controls each unit with the wire file that `identify` has made for
// it, and is compared with an ideal sensor and two simpler loops.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/evaluate/closed_loop/hottest.hpp"
#include "host-sim/evaluate/closed_loop/loop_runs.hpp"
#include "host-sim/replay/error_statistics.hpp"

namespace smaservo::evaluate {

struct ClosedLoopOptions {
  int units = 3;      ///< units of each family, with seeds from `seed` on
  int runs = 108;     ///< runs in each row
  int steps = 27;     ///< steps in each run
  int random = 1000;  ///< number of random scenarios, see hottest.hpp
  /// If set, only the random scenarios are run, with seeds from this one on.
  std::optional<std::uint64_t> random_from;
  std::uint64_t seed = 1000;
  int threads = 1;    ///< does not affect the result
  std::string wires;  ///< folder of the calibrated wires, as in EvaluateOptions
  std::function<void(std::string_view stage, std::size_t done, std::size_t total)> progress;
};

/// The loads of a row.
enum class LoopRow : unsigned char {
  weights,  ///< 100..300 MPa
  spring,   ///< 100..300 MPa
  light     ///< 50 MPa
};
inline constexpr std::array closed_loop_rows{LoopRow::weights, LoopRow::spring, LoopRow::light};

/// The figures of one controller in one row. Errors are in per cent of the nominal stroke.
struct LoopFigures {
  replay::ErrorStatistics error;  ///< error at the end of each step
  /// Settling times, sorted; infinite if a step never settled.
  std::vector<double> heating_s, cooling_s;
  int heated_in_time = 0;    ///< steps settled within 0.10 s
  int cooled_in_time = 0;    ///< steps settled within 1.3 times the ideal sensor's time
  int cycles = 0;            ///< steps that end in a limit cycle
  double above_limit_K = 0;  ///< excess of the hottest point over the limit, in all runs
  std::vector<Fault> trips;  ///< faults of the runs that ended switched off

  double quantile_s(bool heats, double share) const;
};

struct LoopRowResult {
  LoopRow row;
  std::array<LoopFigures, loop_kinds.size()> kinds;  ///< in all runs
  /// The device's in the runs of each family.
  std::array<LoopFigures, hal::tuning_families.size()> device_by_family;
};

struct ClosedLoopEvaluation {
  int units;
  std::uint64_t seed;
  double stroke;
  std::vector<LoopRowResult> rows;
  /// For each controller: the bandwidth on each unit at 200 MPa.
  std::array<std::vector<double>, loop_kinds.size()> bandwidth_Hz;
  std::vector<HottestRun> hottest;  ///< results of the random scenarios
};

/// Throws UserError. Takes about 3 s for each run, and more for each unit that has no wire file in
/// the folder `wires`: `identify` makes it first.
ClosedLoopEvaluation evaluate_closed_loop(const ClosedLoopOptions& options);

std::string closed_loop_markdown(const ClosedLoopEvaluation& evaluation);
std::string closed_loop_json(const ClosedLoopEvaluation& evaluation);

}  // namespace smaservo::evaluate
