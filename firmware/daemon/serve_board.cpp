#include <cstdlib>
#include <fmt/format.h>
#include <functional>
#include <sys/stat.h>
#include <sysexits.h>

#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "firmware/daemon/boards/board_file.hpp"
#include "firmware/daemon/boards/programmed.hpp"
#include "firmware/daemon/bus/bus_service.hpp"
#include "firmware/daemon/serve.hpp"
#include "firmware/text/settings_file.hpp"
#include "hal/linux/can/open_can.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::daemon {
namespace {

/// The folders of the kernel's files; tests name another tree by SMASERVO_ROOT.
hal::LinuxRoots roots() {
  hal::LinuxRoots roots;
  if (const char* const root = std::getenv("SMASERVO_ROOT")) {
    roots = {std::string(root) + "/sys", std::string(root) + "/dev", std::string(root) + "/config"};
  }
  return roots;
}

Settings<double> unconfigured() {
  return text::settings_for(files::load_wire(std::string(files::default_wire)).wire);
}

hal::LinuxBoardParts open_parts(const BoardFile& file) {
  const hal::LinuxRoots where = roots();
  hal::LinuxBoardParts parts;
  // Outputs are opened first, because opening switches them off before anything else can fail.
  parts.drive = open_drive(file, where);
  parts.lines = hal::open_lines(where, file.lines);
  parts.slow = std::make_unique<hal::SlowSensors>(where, file.slow);
  parts.digitizer = open_front_end(file, where);
  parts.calibration = file.calibration;
  return parts;
}

/// Path of the copy of the last run's board file. --off reads it, so that no output stays on if the
/// board file was changed or removed since.
std::string kept_board(const std::string& folder) {
  return folder + "/board.toml";
}

/// Only its owner may read the copy: it contains the bus's access keys.
void keep_board(const std::string& folder, const std::string& text) {
  const mode_t before = umask(0077);
  try {
    files::OutputFile copy(kept_board(folder));
    copy.write(text);
    copy.commit();
  } catch (const files::UserError& error) {
    files::complain(
        "smaservod",
        fmt::format("{}; --off will know only the board file as it is then", error.what()));
  }
  umask(before);
}

/// The board file; nullopt if it is refused. Prints the reason, unless `said`: it has been printed
/// already.
std::optional<BoardFile> usable(const std::string& path, bool said) {
  try {
    return load_board_file(path);
  } catch (const files::ConfigError& error) {
    if (!said) {
      files::complain("smaservod", error.what());
    }
    return {};
  }
}

/// Opens the drive and the lines, which switches them off; each separately, so that a failure of
/// one does not leave the other on.
bool outputs_off(const BoardFile& file) {
  hal::LinuxRoots where = roots();
  where.takes_over = true;
  bool ok = true;
  const auto off = [&](const std::function<void()>& open) {
    try {
      open();
    } catch (const hal::DeviceError& error) {
      files::complain("smaservod", error.what());
      ok = false;
    }
  };
  off([&] { open_drive(file, where); });
  hal::LinesSettings outputs;
  outputs.enable = file.lines.enable;
  outputs.kick = file.lines.kick;
  off([&] { hal::open_lines(where, outputs); });
  return ok;
}

/// Prints a line of the report of --check.
void report_line(std::string_view what, std::string_view text) {
  files::print(fmt::format("{:<16} {}\n", what, files::printable(text)));
}

/// Prints the report's line on the settings; false if the file is refused or exceeds the board.
bool settings_tried(const BoardFile& file) {
  std::string problem;
  try {
    const Settings<double> settings = text::load_settings_file(file.device);
    problem = period_problem(settings);
    problem = problem.empty() ? board_problem(file, settings) : problem;
    problem = problem.empty() ? problem : file.device + ": " + problem;
  } catch (const files::ConfigError& error) {
    problem = error.what();
  }
  report_line("settings", problem.empty() ? "ok" : problem);
  return problem.empty();
}

/// Prints one line of the report; false if the device cannot be opened.
bool tried(const char* what, const std::function<void()>& open) {
  try {
    open();
    report_line(what, "ok");
    return true;
  } catch (const hal::DeviceBusy&) {
    throw;
  } catch (const std::runtime_error& error) {
    report_line(what, error.what());
    return false;
  }
}

/// `unguarded` names the danger that nothing guards against without this line.
bool line_tried(const char* what, const hal::LineSettings& line,
                hal::LineSettings hal::LinesSettings::* which, std::string_view unguarded = "") {
  if (line.name.empty()) {
    report_line(what, unguarded.empty()
                          ? "not in the board file"
                          : fmt::format("warning: not in the board file: {}", unguarded));
    return true;
  }
  hal::LinesSettings one;
  one.*which = line;
  return tried(what, [&] { hal::open_lines(roots(), one); });
}

/// A settings file with an impossible period is refused. Stored settings came over the bus and can
/// only be corrected there: with an impossible period the daemon runs with another one, and the
/// device cannot be armed.
KeptSettings board_settings(const BoardFile& file, const DaemonOptions& options) {
  const bool configured = !options.device.empty();
  const Settings<double> given =
      configured ? text::load_settings_file(options.device) : unconfigured();
  if (const std::string problem = period_problem(given); !problem.empty()) {
    throw files::ConfigError(fmt::format("{}: {}", options.device, problem));
  }
  KeptSettings kept = keep_settings(options.settings, given, configured);
  for (const std::string& line : kept.said) {
    files::complain("smaservod", line);
  }
  if (const std::string problem = board_problem(file, kept.settings); !problem.empty()) {
    files::complain("smaservod", problem + "; the device cannot be armed");
    kept.faults.set(Fault::bad_configuration);
  }
  if (const std::string problem = period_problem(kept.settings); !problem.empty()) {
    files::complain("smaservod", fmt::format("{}: {}; the period of the settings file is used",
                                             options.settings, problem));
    kept.settings.timing.period_s = given.timing.period_s;
    kept.faults.set(Fault::bad_configuration);
  }
  if (file.bus && file.bus->node_id != 0) {
    kept.settings.identity.node_id = file.bus->node_id;
  }
  return kept;
}

}  // namespace

int check_board(const DaemonOptions& options) {
  const BoardFile file = load_board_file(options.board);
  files::print(files::printable(fmt::format("{}: {}", options.board, file.name)) + "\n");
  bool ok = false;
  try {
    ok = tried("drive", [&] { open_drive(file, roots()); });
  } catch (const hal::DeviceBusy& error) {
    report_line("drive", error.what());
    report_line("all others", "not opened: that would disturb the smaservod that runs");
    return 1;
  }
  ok = tried("front end", [&] { open_front_end(file, roots()); }) && ok;
  ok = tried("sensors", [&] { const hal::SlowSensors all(roots(), file.slow); }) && ok;
  ok = line_tried("enable", file.lines.enable, &hal::LinesSettings::enable,
                  "no second switch ends the heat where the drive fails and conducts") &&
       ok;
  ok = line_tried(
           "kick", file.lines.kick, &hal::LinesSettings::kick,
           "no one-shot ends the heat where the program, the kernel or the processor hangs") &&
       ok;
  ok = line_tried("emergency stop", file.lines.emergency_stop,
                  &hal::LinesSettings::emergency_stop) &&
       ok;
  ok = line_tried("driver fault", file.lines.driver_fault, &hal::LinesSettings::driver_fault) && ok;
  if (file.bus) {
    ok = tried("bus", [&] { hal::open_can(file.bus->interface); }) && ok;
  }
  const bool settings_ok = file.device.empty() || settings_tried(file);
  return !settings_ok ? EX_CONFIG : ok ? 0 : 1;
}

int tell_owned(const DaemonOptions& options) {
  return drives(load_board_file(options.board), roots(), options.owns) ? 0 : 1;
}

int switch_board_off(const DaemonOptions& options) {
  // systemd tells an ExecStopPost how the service ended, and with which exit code.
  const char* const result = std::getenv("SERVICE_RESULT");
  const char* const status = std::getenv("EXIT_STATUS");
  const bool refused = status != nullptr && status == std::to_string(EX_CONFIG);
  const std::optional<BoardFile> present = usable(options.board, refused);
  const std::string folder = !options.settings.empty() ? options.settings
                             : present                 ? present->folder
                                                       : default_folder;
  // A result is kept for runs only; a start that was refused was no run.
  if (result != nullptr && std::string(result) != "success" && !refused) {
    try {
      keep_service_result(folder, result);
    } catch (const files::UserError& error) {
      files::complain("smaservod", error.what());
    }
  }
  bool files = present.has_value();
  bool outputs = true;
  // Switches off the outputs of both files; a failure with one must not leave the outputs of the
  // other on.
  if (const std::string copy = kept_board(folder); hal::exists(copy)) {
    const std::optional<BoardFile> kept = usable(copy, false);
    files = files && kept;
    outputs = !kept || (present && present->text == kept->text) || outputs_off(*kept);
  }
  outputs = (!present || outputs_off(*present)) && outputs;
  return !outputs ? 1 : files ? 0 : EX_CONFIG;
}

int serve_board(const DaemonOptions& options) {
  const BoardFile file = load_board_file(options.board);
  DaemonOptions with = options;
  with.device = options.device.empty() ? file.device : options.device;
  with.settings = options.settings.empty() ? file.folder : options.settings;
  const KeptSettings kept = board_settings(file, with);
  hal::LinuxBoard board(open_parts(file));
  ServiceSetup setup = service_setup(with, kept.settings);
  setup.board = file.name;
  setup.thread = file.thread;
  setup.problem = [&](const Settings<double>& settings) { return board_problem(file, settings); };
  Service service(std::move(setup));
  service.links().faults.fetch_or(kept.faults.bits());
  // At this point the service has locked the folder, and nothing has been heated yet.
  keep_board(with.settings, file.text);
  if (!options.program.empty()) {
    say_start(options, file.name, "", kept);
    Programmed programmed(bench::load_closed_loop(options.program).program);
    return serve(service, board, programmed, timing_of(kept.settings, options.for_s), true);
  }
  NoCommandSource nobody;
  std::unique_ptr<BusService> bus;
  if (file.bus) {
    bus = std::make_unique<BusService>(
        BusSetup{file.bus->interface, file.bus->lost_after_s, with.settings, file.ceilings,
                 file.bus->keys, file.bus->unattended, file.name,
                 with.real_time ? bus_priority(file.thread) : 0, kept.lost},
        service.desk(), service.links(), service.figures());
    bus->start();
  }
  CommandSource& source = bus ? bus->command_source() : nobody;
  say_start(options, file.name, file.bus ? file.bus->interface : "", kept);
  return serve(service, board, source, timing_of(kept.settings, options.for_s), true);
}

}  // namespace smaservo::daemon
