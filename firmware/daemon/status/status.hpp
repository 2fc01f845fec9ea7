#pragma once
// The daemon's status: written to a file once a second, and printed at its end.

#include <optional>
#include <string>
#include <vector>

#include "firmware/daemon/loop/links.hpp"
#include "firmware/daemon/process/last_run.hpp"
#include "firmware/daemon/status/loop_usage.hpp"

namespace smaservo::daemon {

struct RecordingStatus {
  std::string path;
  std::uint64_t rows;
  std::string problem;
};

struct Status {
  std::string board;
  std::int64_t period_ns;
  const LoopFigures& figures;
  const Output<double>& output;  ///< the newest output
  LoopUsage::Taken usage;
  std::optional<RecordingStatus> recording;
  std::string last_run;               ///< empty if no marks are kept
  std::vector<std::string> warnings;  ///< all warnings so far
};

/// JSON in one line; names carry their units, null is an unknown value.
std::string status_json(const Status& status);
/// Text for a terminal.
std::string status_text(const Status& status);

}  // namespace smaservo::daemon
