#pragma once
// What a daemon says while it runs, by the main's thread: sentences in the log, and its status.

#include <memory>
#include <string>
#include <vector>

#include "firmware/daemon/status/loop_usage.hpp"
#include "firmware/daemon/status/status.hpp"

namespace smaservo::daemon {

class Recorder;

/// Whose status it is; all of it outlives the writer.
struct StatusSources {
  LoopLinks& links;
  const LoopFigures& figures;
  LoopUsage& usage;
  const std::unique_ptr<RunMark>& mark;       ///< null: there is none
  const std::unique_ptr<Recorder>& recorder;  ///< likewise
};

class StatusWriter {
 public:
  /// `file` empty: none is written.
  StatusWriter(std::string file, std::string board, std::int64_t period_ns,
               const StatusSources& sources);

  /// To the log, and kept for the status.
  void warn(const std::string& text);
  /// Takes the loop's newest output; the log gets faults that are new in it.
  void look();
  const Output<double>& output() const { return output_; }

  /// `runs`: the loop does.
  Status status(bool runs) const;
  /// To the file. One that can not be written is a warning, once.
  void write(bool runs);

 private:
  std::string file_, board_;
  std::int64_t period_ns_;
  StatusSources from_;
  Output<double> output_{};
  FaultSet logged_;
  std::vector<std::string> warnings_;
  bool fails_ = false;
};

}  // namespace smaservo::daemon
