#pragma once

#include <string>

namespace smaservo::daemon {

/// Of the command line.
struct DaemonOptions {
  std::string board = "/etc/smaservo/board.toml";  ///< file, "sim", "sim=FILE" or "replay=TRACE"
  std::string device;                              ///< settings file; empty: the board's
  std::string settings;                            ///< folder of the store; empty: the board's
  std::string program;                             ///< scenario file, in a command source's place
  std::string bus;                                 ///< of a simulated wire
  std::string record;
  std::string status;
  double for_s = 0;  ///< 0: no end
  bool check = false;
  bool off = false;
  bool json = false;
  bool at_once = false;  ///< simulated time runs as fast as it can
  bool real_time = true;
  bool sandboxed = false;  ///< the loop dies of any system call but a loop's
};

/// True: run; false: the exit code is in `code`.
bool parse_options(int argc, char** argv, DaemonOptions& options, int& code);

/// A run within the same process: a recording in a file of its own has ended with the one before.
void prepare_next_run(DaemonOptions& options);

}  // namespace smaservo::daemon
