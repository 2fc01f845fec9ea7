#pragma once

#include <string>

namespace smaservo::daemon {

/// The options of the command line.
struct DaemonOptions {
  /// Board file, "sim", "sim=FILE" or "replay=TRACE".
  std::string board = "/etc/smaservo/board.toml";
  std::string device;    ///< settings file; empty: that of the board file
  std::string settings;  ///< folder of the store; empty: that of the board file
  std::string program;   ///< scenario file whose commands replace the bus
  std::string bus;       ///< CAN interface, for a simulated wire only
  std::string record;
  std::string status;
  double for_s = 0;  ///< duration of the run; 0: no end
  std::string owns;  ///< name of a kernel device whose owner is asked for; empty: none
  bool check = false;
  bool off = false;
  bool json = false;
  bool at_once = false;  ///< simulated time runs as fast as possible
  bool real_time = true;
  bool quiet = false;      ///< no line about what runs when a run begins
  bool sandboxed = false;  ///< restricts the loop's system calls, see sandbox.hpp
};

/// True: run the daemon; false: end with the exit code in `code`.
bool parse_options(int argc, char** argv, DaemonOptions& options, int& code);

/// Prepares a further run in the same process. The run is recorded only if `record` is a folder: a
/// file ended with the previous run.
void prepare_next_run(DaemonOptions& options);

}  // namespace smaservo::daemon
