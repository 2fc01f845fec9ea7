#pragma once
// The daemon's messages during a run: sentences in the log, and its status. Used by the main
// thread.

#include <memory>
#include <string>
#include <vector>

#include "firmware/daemon/status/loop_usage.hpp"
#include "firmware/daemon/status/status.hpp"
#include "firmware/daemon/status/warning_journal.hpp"

namespace smaservo::daemon {

class Recorder;

/// The sources of the status; all of them must outlive the writer.
struct StatusSources {
  LoopLinks& links;
  const LoopFigures& figures;
  LoopUsage& usage;
  const std::unique_ptr<RunMark>& mark;       ///< null: there is none
  const std::unique_ptr<Recorder>& recorder;  ///< null: nothing is recorded
};

class StatusWriter {
 public:
  /// `file` empty: no status file is written.
  StatusWriter(std::string file, std::string board, std::int64_t period_ns,
               const StatusSources& sources);

  /// Writes a warning to the log and keeps it for the status.
  void warn(const std::string& text);
  /// Takes the loop's newest output and writes new faults and warnings to the log.
  void look();
  const Output<double>& output() const { return output_; }

  /// `runs`: whether the loop runs.
  Status status(bool runs) const;
  /// Writes the status file; the first failure is a warning.
  void write(bool runs);

 private:
  std::string file_, board_;
  std::int64_t period_ns_;
  StatusSources from_;
  Output<double> output_{};
  FaultSet logged_;
  WarningJournal journal_;
  std::vector<std::string> warnings_;
  bool fails_ = false;
};

}  // namespace smaservo::daemon
