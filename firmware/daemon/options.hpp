#pragma once

#include <string>

namespace smaservo::daemon {

/// The options of the command line.
struct DaemonOptions {
  std::string board = "/etc/smaservo/board.toml";  ///< file, "sim", "sim=FILE" or "replay=TRACE"
  std::string device;                              ///< settings file; empty: the board's
  std::string settings;                            ///< folder of the store; empty: the board's
  std::string program;                             ///< scenario file whose commands replace the bus
  std::string bus;                                 ///< interface, for a simulated wire only
  std::string record;
  std::string status;
  double for_s = 0;  ///< 0: no end
  std::string owns;  ///< name of a device of the kernel; empty: nobody asks
  bool check = false;
  bool off = false;
  bool json = false;
  bool at_once = false;  ///< simulated time runs as fast as it can
  bool real_time = true;
  bool sandboxed = false;  ///< restricts the loop's system calls, see sandbox.hpp
};

/// True: run the daemon; false: end with the exit code in `code`.
bool parse_options(int argc, char** argv, DaemonOptions& options, int& code);

/// Prepares a further run in the same process. It records only if `record` is a folder: a file has
/// ended with the run before.
void prepare_next_run(DaemonOptions& options);

}  // namespace smaservo::daemon
