#include "firmware/daemon/options.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

namespace smaservo::daemon {
namespace {

constexpr int wrong_command_line = 2;

/// Folders that systemd has made for the service.
std::string folder_of(const char* variable) {
  const char* const value = std::getenv(variable);
  return value == nullptr ? "" : value;
}

}  // namespace

bool parse_options(int argc, char** argv, DaemonOptions& options, int& code) {
  CLI::App app{"Drives a shape-memory-alloy wire as a position servo.", "smaservod"};
  app.set_version_flag("--version", SMASERVO_VERSION);
  app.add_option("--board", options.board,
                 "board file; sim or sim=SCENARIO.toml: a simulated wire; replay=TRACE.csv: a "
                 "recording")
      ->capture_default_str();
  app.add_option("--device", options.device,
                 "settings file, where the store has none; default: the board file's, the "
                 "scenario's, or TRACE.csv.toml");
  app.add_option("--settings", options.settings,
                 "folder of the stored settings and of the run's mark; default: $STATE_DIRECTORY, "
                 "or the board file's");
  app.add_option(
      "--program", options.program,
      "do what this scenario's commands say, in the place of a command source on the bus");
  app.add_option("--bus", options.bus,
                 "of a simulated wire: a CAN interface, or udp, udp:GROUP, udp:GROUP:PORT");
  app.add_option("--record", options.record,
                 "write a trace that host-sim replay --device takes; in a folder it is named by "
                 "the time");
  app.add_option("--status", options.status,
                 "file that says once a second how it runs; default: status.json in "
                 "$RUNTIME_DIRECTORY");
  app.add_option("--for", options.for_s, "stop after so many seconds of periods")
      ->check(CLI::Range(0.0, 1e9));
  app.add_flag("--check", options.check, "open all that the board file names, report, and stop");
  app.add_flag("--off", options.off, "switch the board's outputs off and stop: for ExecStopPost");
  app.add_flag("--json", options.json, "print the figures at the end as JSON");
  app.add_flag("--at-once", options.at_once, "a simulated wire's time runs as fast as it can");
  app.add_flag("!--no-real-time", options.real_time, "neither lock memory nor ask for a priority");
  app.add_flag("--sandbox", options.sandboxed,
               "for a proof: die when the loop makes any system call but a loop's");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    code = app.exit(error) == 0 ? 0 : wrong_command_line;
    return false;
  }
  if (options.settings.empty()) {
    options.settings = folder_of("STATE_DIRECTORY");
  }
  const std::string runtime = folder_of("RUNTIME_DIRECTORY");
  if (options.status.empty() && !runtime.empty()) {
    options.status = runtime + "/status.json";
  }
  return true;
}

void prepare_next_run(DaemonOptions& options) {
  std::fputs("smaservod: reset over the bus\n", stderr);
  if (!options.record.empty() && !std::filesystem::is_directory(options.record)) {
    std::fputs("smaservod: the recording has ended: only in a folder the next run gets one\n",
               stderr);
    options.record.clear();
  }
}

}  // namespace smaservo::daemon
