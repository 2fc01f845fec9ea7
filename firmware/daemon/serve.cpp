#include "firmware/daemon/serve.hpp"

#include <cmath>
#include <exception>
#include <fmt/format.h>
#include <optional>

#include "firmware/daemon/boards/replaying.hpp"
#include "firmware/daemon/boards/simulation.hpp"
#include "firmware/daemon/bus/bus_service.hpp"
#include "firmware/text/settings_file.hpp"
#include "hal/linux/can/open_can.hpp"
#include "model/files/message.hpp"

namespace smaservo::daemon {
namespace {

std::string after_equals(const std::string& text) {
  const std::size_t equals = text.find('=');
  return equals == std::string::npos ? "" : text.substr(equals + 1);
}

/// The scenario that --board sim runs.
bench::ClosedLoopScenario simulated(const DaemonOptions& options) {
  const std::string file = after_equals(options.board);
  bench::ClosedLoopScenario scenario =
      file.empty() ? bench::standard_closed_loop(options.device.empty()
                                                     ? bench::standard_settings()
                                                     : text::load_settings_file(options.device))
                   : bench::load_closed_loop(file);
  if (!file.empty() && !options.device.empty()) {
    scenario.settings = text::load_settings_file(options.device);
  }
  return scenario;
}

Settings<double> recorded(const DaemonOptions& options) {
  return text::load_settings_file(options.device.empty() ? after_equals(options.board) + ".toml"
                                                         : options.device);
}

/// Tries one part of a check. If it is refused, the exception ends the check with the same exit
/// code as a run.
template <class Try>
void report(const char* what, Try attempt) {
  try {
    attempt();
  } catch (const std::exception& error) {
    files::print(fmt::format("{:<16} {}\n", what, error.what()));
    throw;
  }
  files::print(fmt::format("{:<16} ok\n", what));
}

}  // namespace

void say_start(const DaemonOptions& options, const std::string& board, const std::string& bus,
               const KeptSettings& kept) {
  if (options.quiet) {
    return;
  }
  const auto& geometry = kept.settings.wire.geometry;
  const bool has_wire = !kept.faults.has(Fault::not_configured);
  files::complain(
      "smaservod",
      fmt::format(
          "board {}, {}, {}, loop {:.3g} ms; current off until {}", board,
          bus.empty() ? "no bus"
                      : fmt::format("bus {}, node-id {}", bus, kept.settings.identity.node_id),
          has_wire ? fmt::format("wire {:.3g} um x {:.4g} mm", 1e6 * geometry.diameter_m,
                                 1e3 * geometry.length_m)
                   : "no wire configured",
          1e3 * kept.settings.timing.period_s, bus.empty() ? "its program heats" : "enabled"));
}

LoopTiming timing_of(const Settings<double>& settings, double for_s) {
  const double period_s = settings.timing.period_s;
  const std::int64_t period_ns = std::llround(period_s * 1e9);
  return {.period_ns = period_ns,
          .from_zero = true,
          .max_cycles = static_cast<std::uint64_t>(std::llround(for_s / period_s))};
}

ServiceSetup service_setup(const DaemonOptions& options, const Settings<double>& settings) {
  return {.board = options.board,
          .settings = settings,
          .settings_file = options.device,
          .folder = options.settings,
          .record = options.record,
          .status = options.status,
          .json = options.json,
          .real_time = options.real_time,
          .paced = true,
          .sandboxed = options.sandboxed,
          .thread = {},
          .problem = nullptr};
}

int serve_simulation(const DaemonOptions& options) {
  const bench::ClosedLoopScenario scenario = simulated(options);
  const KeptSettings kept = keep_settings(options.settings, scenario.settings, true);
  if (!kept.faults.empty()) {
    for (const std::string& line : kept.said) {
      files::complain("smaservod", line);
    }
  }
  ServiceSetup setup = service_setup(options, kept.settings);
  setup.real_time = options.real_time && !options.at_once;
  setup.paced = !options.at_once;
  Service service(std::move(setup));
  service.links().faults.fetch_or(kept.faults.bits());
  Simulation board(scenario);
  Demonstration demonstration(kept.settings);
  std::unique_ptr<BusService> bus;
  if (!options.bus.empty()) {
    const int priority = options.real_time && !options.at_once ? bus_priority({}) : 0;
    bus = std::make_unique<BusService>(
        BusSetup{options.bus, 0, options.settings, {}, {}, false, "simulated", priority, kept.lost},
        service.desk(), service.links(), service.figures());
    bus->start();
  }
  CommandSource& source = bus                        ? bus->command_source()
                          : scenario.program.empty() ? static_cast<CommandSource&>(demonstration)
                                                     : board;
  say_start(options, options.board, options.bus, kept);
  return serve(service, board, source, timing_of(kept.settings, options.for_s), !options.at_once);
}

int serve_replay(const DaemonOptions& options) {
  const std::string trace = after_equals(options.board);
  const Settings<double> settings = recorded(options);
  ServiceSetup setup = service_setup(options, settings);
  setup.settings_file.clear();
  setup.folder.clear();  // a replay leaves no mark, and takes its settings only from the recording
  setup.real_time = setup.paced = false;
  Service service(std::move(setup));
  Replaying board(trace, settings, service.desk());
  LoopTiming timing = timing_of(settings, options.for_s);
  timing.from_zero = false;
  return serve(service, board, board, timing, false);
}

int check_simulation(const DaemonOptions& options) {
  std::optional<bench::ClosedLoopScenario> scenario;
  if (!options.device.empty()) {
    report("settings file", [&] { text::load_settings_file(options.device); });
  }
  report("scenario", [&] {
    scenario = simulated(options);
    const Simulation board(*scenario);
  });
  report("settings", [&] { keep_settings(options.settings, scenario->settings, true); });
  if (!options.bus.empty()) {
    report("bus", [&] { hal::open_can(options.bus); });
  }
  return 0;
}

int check_replay(const DaemonOptions& options) {
  std::optional<Settings<double>> settings;
  report("settings", [&] { settings = recorded(options); });
  report("trace", [&] {
    LoopLinks links;
    ParameterDesk desk(*settings, links);
    const Replaying board(after_equals(options.board), *settings, desk);
  });
  return 0;
}

}  // namespace smaservo::daemon
