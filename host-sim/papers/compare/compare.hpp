#pragma once
// All systems, identified on the same runs and asked about the same others.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/papers/compare/system.hpp"
#include "host-sim/replay/error_statistics.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::compare {

/// What a system makes of one run.
struct SystemRun {
  std::vector<double> strain;     ///< of every row, NaN where it says nothing
  replay::ErrorStatistics error;  ///< in % of the nominal stroke
};

struct Compared {
  System system;
  std::vector<SystemRun> runs;    ///< as the tests; empty when it was not identified
  replay::ErrorStatistics error;  ///< over all tests
  double step_s = 0;              ///< time for a row, of tests that it says something about
};

/// How much of a test lies outside of what the training runs went through, so that every system
/// extrapolates there: shares of its rows.
struct Beyond {
  double stress = 0;      ///< by more than 2 MPa
  double resistance = 0;  ///< by more than 0.2 %
};

struct Comparison {
  std::string from;
  double nominal_stroke;
  std::vector<identify::Run> training, tests;
  std::vector<bool> free_zero;  ///< of a test: nobody knows its absolute strain
  std::vector<Beyond> beyond;   ///< of a test
  std::vector<Compared> systems;
};

/// A system that the training runs can not identify is listed with the reason. Where a test's
/// strain is a displacement, with a zero of its own, every system's median error is taken off. Such
/// a training run is moved so that it is longest where `from` is at rest under its load. Throws
/// UserError for runs other than of Joule heating or in a bath, a training or test run without
/// strain, and when not even one system could be identified.
Comparison compare(const files::WireDescription& from, std::vector<identify::Run> training,
                   std::vector<identify::Run> tests, int threads,
                   const std::function<void(std::string_view)>& progress);

std::string comparison_text(const Comparison& comparison);
std::string comparison_json(const Comparison& comparison);
/// Throws UserError.
void write_comparison_report(const std::string& path, const Comparison& comparison);

}  // namespace smaservo::compare
