#include "firmware/daemon/options.hpp"

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "model/files/message.hpp"
#include "model/files/wrapped.hpp"

namespace smaservo::daemon {
namespace {

constexpr int wrong_command_line = 2;

/// The folder that systemd has created for the service, from its environment variable.
std::string folder_of(const char* variable) {
  const char* const value = std::getenv(variable);
  return value == nullptr ? "" : value;
}

}  // namespace

bool parse_options(int argc, char** argv, DaemonOptions& options, int& code) {
  CLI::App app{"Drives a shape-memory-alloy wire as a position servo.", "smaservod"};
  app.set_version_flag("--version", SMASERVO_VERSION);
  // CLI11's own message, made printable because it quotes the command line.
  app.failure_message([](const CLI::App*, const CLI::Error& error) {
    return files::printable(error.what()) + "\nRun with --help for more information.\n";
  });
  app.formatter_fn([](const CLI::App* of, std::string name, CLI::AppFormatMode mode) {
    return files::wrapped_help(CLI::Formatter().make_help(of, std::move(name), mode));
  });
  app.add_option("--board", options.board,
                 "board file; sim or sim=SCENARIO.toml: a simulated wire; replay=TRACE.csv: a "
                 "recording")
      ->capture_default_str();
  app.add_option("--device", options.device,
                 "settings file, used while nothing is stored; default: the board file's, the "
                 "scenario's, or TRACE.csv.toml");
  app.add_option("--settings", options.settings,
                 "folder of the stored settings and of the mark that tells how a run ended; "
                 "default: $STATE_DIRECTORY, or the board file's");
  app.add_option("--program", options.program,
                 "obey the commands of this scenario instead of the bus");
  app.add_option("--bus", options.bus,
                 "bus of a simulated wire: a CAN interface, or udp, udp:GROUP, udp:GROUP:PORT");
  app.add_option("--record", options.record,
                 "record a trace for host-sim replay-device, as MCAP if the name ends in .mcap; in "
                 "a folder its name is the time");
  app.add_option("--status", options.status,
                 "file for the state and the figures of the run, rewritten once a second; default: "
                 "status.json in $RUNTIME_DIRECTORY");
  app.add_option("--for", options.for_s,
                 "stop after this many seconds, counted in periods of the loop")
      ->check(CLI::Range(0.0, 1e9));
  app.add_flag("--check", options.check,
               "open each device that the board file names, report, and stop");
  app.add_flag("--off", options.off,
               "switch the board's outputs off and stop (ExecStopPost of the service)");
  app.add_option("--owns", options.owns,
                 "end with 0 if the board file names this device of the kernel (for udev), such as "
                 "spidev0.0, iio:device0, gpiochip0, pwmchip0; else with 1");
  app.add_flag("--json", options.json, "print the final figures as JSON");
  app.add_flag("--at-once", options.at_once,
               "run a simulated wire as fast as the machine can, not in real time");
  app.add_flag("!--no-real-time", options.real_time,
               "do not lock memory, do not ask for a real-time priority");
  app.add_flag("--quiet", options.quiet, "leave out the line that says what runs");
  app.add_flag("--sandbox", options.sandboxed,
               "die at any system call that the loop is not allowed, to prove that it makes none");
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
  files::complain("smaservod", "reset over the bus");
  if (!options.record.empty() && !std::filesystem::is_directory(options.record)) {
    files::complain("smaservod",
                    "the recording has ended; only --record FOLDER records the next run too");
    options.record.clear();
  }
}

}  // namespace smaservo::daemon
