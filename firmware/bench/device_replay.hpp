#pragma once
// Runs the firmware's whole step on a recorded trace and compares the outputs.

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
  std::string out;  ///< CSV, "-" for standard output; empty: none
  /// Allowed difference of numbers, as a share of their range in the trace; texts must be the same.
  double tolerance = 0;
};

/// How one output differs from the trace's.
struct OutputDifference {
  std::string column;
  std::uint64_t rows = 0;     ///< rows that differ in any bit
  double first_s = 0;         ///< time of the first such row
  std::string recorded, now;  ///< both texts of that row
  double max = 0;             ///< greatest difference of numbers; 0 for texts
  bool tolerated = false;     ///< all differences are within the tolerance
};

struct DeviceReplayResult {
  std::uint64_t rows = 0, skipped = 0;
  double duration_s = 0;
  std::vector<std::string> compared;          ///< outputs that the trace has
  std::uint64_t differing_rows = 0;           ///< rows that differ in any output
  std::vector<OutputDifference> differences;  ///< outputs that differ anywhere
  std::vector<std::string> complaints;
  /// Columns that were taken under former names: "wire_K is now called ...".
  std::vector<std::string> renamed;
};

/// Beside its readings the trace must have command_mode, command_setpoint and command_arm. Other
/// columns may be missing: then every row has a fresh command, gains are scaled by 1, no fault is
/// cleared and no deadline missed. Throws UserError, TraceError.
DeviceReplayResult replay_device(const DeviceReplayOptions& options);

/// Whether no output differs by more than the tolerance.
bool agrees(const DeviceReplayResult& result);

/// The result for a terminal.
std::string summary(const DeviceReplayOptions& options, const DeviceReplayResult& result);

}  // namespace smaservo::bench
