#pragma once
// Adds runs to a folder of recordings, or makes one.

#include <functional>
#include <string>
#include <vector>

#include "host-sim/record/run.hpp"

namespace smaservo::record {

/// A run that is to be added, under this name.
struct NamedRun {
  std::string name;  ///< empty: that of its file
  RunSource source;
};

struct RecordTask {
  std::string card, out;  ///< paths
  std::vector<NamedRun> runs;
};

/// All runs, or none. The result says what was done. Throws UserError and TraceError; the folder is
/// then as it was before.
std::string record_runs(const RecordTask& task);

struct BusTask {
  std::string card, out;
  std::string name;  ///< empty: run-001, run-002, ...
  std::vector<std::string> allowed;
  std::string from;  ///< for messages: "node 1 on can0"
};

/// What has been recorded: rows as CSV.
struct Recorded {
  std::string csv;
  std::size_t left_out = 0;  ///< rows without a reading
};

/// Judges card, folder and name; then calls `record`, and adds what that gives. Where this then
/// fails, the recording is not lost: it becomes a file OUT-NAME.csv, which the message names.
std::string record_bus(const BusTask& task, const std::function<Recorded()>& record);

}  // namespace smaservo::record
