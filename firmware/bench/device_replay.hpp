#pragma once
// The whole step of the firmware on a recorded trace.

#include <cstdint>
#include <string>
#include <vector>

#include "firmware/settings.hpp"
#include "hal/replay/trace.hpp"

namespace smaservo::bench {

struct DeviceReplayOptions {
  std::string trace;  ///< path, "-" for standard input
  hal::TraceOptions trace_options;
  Settings<double> settings;
  std::string out;       ///< CSV, "-" for standard output; empty: none
  double tolerance = 0;  ///< of numbers, share of their range in the trace; texts must be the same
};

/// How an output came out beside what the trace has of it.
struct OutputDifference {
  std::string column;
  std::uint64_t rows = 0;     ///< that differ in any bit
  double first_s = 0;         ///< time of the first one
  std::string recorded, now;  ///< texts of the first one
  double max = 0;             ///< of numbers; 0 for texts
  bool tolerated = false;     ///< all of them
};

struct DeviceReplayResult {
  std::uint64_t rows = 0, skipped = 0;
  double duration_s = 0;
  std::vector<std::string> compared;          ///< outputs that the trace has
  std::uint64_t differing_rows = 0;           ///< in any output
  std::vector<OutputDifference> differences;  ///< outputs that differ anywhere
  std::vector<std::string> complaints;
};

/// The trace must have command_mode, command_setpoint and command_arm beside its readings; without
/// command_fresh every row has a fresh command, gains are scaled by 1, nothing is cleared and no
/// deadline missed. Throws UserError, TraceError.
DeviceReplayResult replay_device(const DeviceReplayOptions& options);

/// No output differs, or only within the tolerance.
bool agrees(const DeviceReplayResult& result);

/// The result for a terminal.
std::string summary(const DeviceReplayOptions& options, const DeviceReplayResult& result);

}  // namespace smaservo::bench
