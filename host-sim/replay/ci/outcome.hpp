#pragma once
// How the replay of one trace has ended, and what continuous integration is told of it.

#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host-sim/replay/ci/bounds.hpp"

namespace smaservo::replay {

struct Outcome {
  std::string trace;                   ///< as given; "-" is standard input
  std::optional<ReplayResult> result;  ///< without its plots; none: it could not be replayed
  bool judged = false;                 ///< bounds were given
  std::vector<std::string> misses;
  std::vector<std::string> errors;  ///< why it could not be replayed or judged
  std::string lost;                 ///< why the result is of no use; empty: it is
  double elapsed_s = 0;

  std::string name() const { return trace == "-" ? "standard input" : trace; }
};

/// Compares the result with these bounds.
void judge(Outcome& outcome, const ReplayResult& result, std::span<const Bounds> bounds);

/// The worst one: 1 for an error or a missed bound, 3 for a result of no use, 0.
int exit_status(std::span<const Outcome> outcomes);

/// JUnit XML: one suite, which began at this time, and a case for each trace.
std::string junit_xml(std::span<const Outcome> outcomes,
                      std::chrono::system_clock::time_point began);

/// A Markdown table with a row for each trace.
std::string summary_markdown(std::span<const Outcome> outcomes);

}  // namespace smaservo::replay
