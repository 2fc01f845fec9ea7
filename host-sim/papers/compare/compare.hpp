#pragma once
// Identifies all systems on the same training runs, and tests them on the same test runs.

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/papers/compare/system.hpp"
#include "host-sim/replay/error_statistics.hpp"
#include "host-sim/units.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::compare {

/// The result of a system for one test.
struct SystemRun {
  std::vector<double> strain;     ///< strain in every row; NaN without an estimate
  replay::ErrorStatistics error;  ///< in % of the nominal stroke
};

struct Compared {
  System system;
  std::vector<SystemRun> runs;    ///< one for each test; empty if the system was not identified
  replay::ErrorStatistics error;  ///< error over all tests
  double step_s = 0;              ///< computing time for a row, in the tests with an estimate
};

/// The shares of a test's rows outside of the stresses and resistances of the training runs, where
/// every system extrapolates.
struct Beyond {
  double stress = 0;      ///< outside by more than 2 MPa
  double resistance = 0;  ///< outside by more than 0.2 %
};

struct Comparison {
  std::string from;
  double nominal_stroke;
  std::vector<identify::Run> training, tests;
  std::vector<bool> free_zero;  ///< for each test: whether its absolute strain is unknown
  std::vector<Beyond> beyond;   ///< values for each test
  std::vector<Compared> systems;
};

/// Called when the work on a system begins, with the share of the whole work that is done by then,
/// 0 to 1, as comparisons usually go.
using Progress = std::function<void(std::string_view system, double share)>;

/// A system that the training runs cannot identify is listed with the reason. If a test's strain is
/// a displacement, which has its own zero, the median error of every system is subtracted. A
/// training run with such a strain is moved so that its longest wire is as long as `from` at rest
/// under that load. Throws UserError for runs other than of Joule heating or in a bath, for a
/// training or test run without strain, and if not even one system could be identified. A trained
/// `network` is one system more.
Comparison compare(const files::WireDescription& from, std::vector<identify::Run> training,
                   std::vector<identify::Run> tests, int threads, const Progress& progress,
                   const std::optional<gru::Network>& network = {});

std::string comparison_text(const Comparison& comparison);
std::string comparison_json(const Comparison& comparison);
/// Throws UserError.
void write_comparison_report(const std::string& path, const Comparison& comparison, Units units);

}  // namespace smaservo::compare
