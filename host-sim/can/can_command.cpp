#include "host-sim/can/can_command.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <unistd.h>
#include <utility>

#include "firmware/safety/faults/table.hpp"
#include "firmware/text/fault_reference.hpp"
#include "firmware/text/settings_file.hpp"
#include "firmware/text/settings_text.hpp"
#include "hal/recording/trace_file.hpp"
#include "host-sim/can/bus/network.hpp"
#include "host-sim/can/bus/port_bus.hpp"
#include "host-sim/can/outcome.hpp"
#include "host-sim/can/positions.hpp"
#include "host-sim/can/settings.hpp"
#include "host-sim/can/shown.hpp"
#include "host-sim/can/status.hpp"
#include "host-sim/can/step_test.hpp"
#include "host-sim/can/watch.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::can {
namespace {

constexpr const char* about_gains =
    "The gains strain.proportional_W, strain.integral_1_s and strain.derivative_s are 0 by\n"
    "default: the model alone drives the wire. `host-sim tune` proposes gains.";

struct Common {
  std::string can;
  unsigned node = 1;
  std::optional<std::uint32_t> key;
  double timeout_s = 0.5;
  Units units = Units::bench;
  bool quiet = false;
};

/// The bus and the node that a run uses.
class Session {
 public:
  explicit Session(const Common& common) : bus_(common.can), remote_({bus_, common.node}) {
    remote_.client().set_timeout(static_cast<std::int64_t>(common.timeout_s * 1e6));
    if (common.key) {
      remote_.set("access.key", std::to_string(*common.key));
    }
  }

  can::PortBus& bus() { return bus_; }
  Remote& remote() { return remote_; }

 private:
  can::PortBus bus_;
  Remote remote_;
};

void print(const std::string& text) {
  files::print(text);
  std::fflush(stdout);
}

/// Says on the standard error output what a command has made so. The command has worked by then, so
/// a failure to read for this does not make it fail.
void say(const Common& common, const std::function<std::string()>& text) {
  if (common.quiet) {
    return;
  }
  try {
    files::print(text(), stderr);
  } catch (const files::UserError& error) {
    files::complain("host-sim", error.what());
  }
}

CLI::App* add(CLI::App& can, const char* name, const char* meaning,
              const std::function<void()>& run) {
  CLI::App* command = can.add_subcommand(name, meaning);
  command->fallthrough();
  command->callback(run);
  return command;
}

/// Like CLI::Range, but refuses NaN as well.
CLI::Validator seconds_of(double low, double high) {
  return {[=](std::string& text) {
            double value = 0;
            const bool fits =
                CLI::detail::lexical_cast(text, value) && low <= value && value <= high;
            return fits ? "" : fmt::format("{} is not within {} to {} s", text, low, high);
          },
          fmt::format("{} to {}", low, high)};
}

/// Adds a command that has no options of its own.
void add_plain(CLI::App& can, const std::shared_ptr<Common>& common, const char* name,
               const char* meaning, void (*run)(Remote&, const Common&)) {
  add(can, name, meaning, [common, run] {
    Session session(*common);
    run(session.remote(), *common);
  });
}

// Network.

void scan(const Common& common, double listen_s) {
  can::PortBus bus(common.can);
  const can::FoundNodes found = can::scan(bus, static_cast<std::int64_t>(listen_s * 1e6));
  files::TextTable table({{"", "{}"}, {""}, {""}});
  for (const can::FoundNode& node : found.nodes) {
    const can::SdoClient client(bus, node.node);
    Remote remote(client);
    table.add({node.node, node.nmt_state ? can::nmt_state_text(*node.nmt_state) : "",
               node.answers ? remote.text("1008") : "does not answer to SDO"});
  }
  if (found.without_id) {
    table.add({"?", "without a node-id", "answers to LSS"});
  }
  print(table.text());
  if (found.nodes.empty() && !found.without_id) {
    throw files::UserError(fmt::format("{}: no node answers", bus.name()));
  }
}

void listen(const Common& common, double for_s) {
  can::PortBus bus(common.can);
  const std::int64_t start_us = bus.now_us();
  const std::int64_t until_us = start_us + static_cast<std::int64_t>(for_s * 1e6);
  hal::CanFrame frame;
  while (bus.receive(frame, until_us)) {
    print(fmt::format("{:10.4f}  {}\n", static_cast<double>(bus.now_us() - start_us) * 1e-6,
                      can::frame_text(frame)));
  }
}

// Objects.

void get(Remote& remote, const std::vector<std::string>& names, Units units) {
  for (const std::string& name : names) {
    const can::Shown shown = can::shown_object(name, units);
    const std::optional<Kind> mode = shown.by_mode ? can::kind_in_force(remote) : std::nullopt;
    can::require_in_force(shown, mode);
    const text::KnownObject object = can::in_force(shown, mode, units);
    const std::string value = text::value_text(object, remote.read(object));
    const bool alone = names.size() == 1 && shown.names_unit;
    files::print(files::printable(alone ? value : object.name + " = " + value) + "\n");
    if (shown.by_mode && !mode) {
      files::print(fmt::format("{}: {}\n", object.name, can::unknown_mode), stderr);
    }
  }
}

std::string no_value(const std::string& name) {
  return fmt::format("{}: has no value; must be NAME VALUE or NAME=VALUE", name);
}

/// The change of an object to a value that may have a unit behind it; the object is then in this
/// unit.
can::Change change_of(const std::string& name, const std::string& value) {
  bool unitless = false;
  text::KnownObject object = text::find_quantity(name, unitless);
  if (value.empty() && object.type != canopen::Type::text) {
    throw files::UserError(no_value(name));
  }
  if (!object.writable) {
    throw files::UserError(fmt::format("{} cannot be written", text::title(object)));
  }
  const std::optional<text::Quantity> quantity =
      object.kind.empty() ? std::nullopt : text::quantity_of(value);
  if (quantity && quantity->unit.empty() && unitless) {
    throw files::UserError(
        fmt::format("{} = {}: needs a unit, in the name or behind the number: {}", name, value,
                    text::suffixes_text(object.kind)));
  }
  const can::Bytes bytes = text::value_bytes(object, value);
  const std::optional<Unit> unit =
      quantity ? quantity->unit_in(object.kind, object.unit) : std::nullopt;
  if (unit) {
    object = text::in_unit(object, *unit);
  }
  return {object, bytes};
}

std::vector<can::Change> changes_of(const std::vector<std::string>& texts) {
  std::vector<can::Change> changes;
  if (texts.size() == 2 && texts[0].find('=') == std::string::npos) {
    return {change_of(texts[0], texts[1])};
  }
  changes.reserve(texts.size());
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
      throw files::UserError(no_value(text));
    }
    if (equals == 0) {
      throw files::UserError(
          fmt::format("{}: has no name; must be NAME VALUE or NAME=VALUE", text));
    }
    can::Change change = change_of(text.substr(0, equals), text.substr(equals + 1));
    const Key key = change.first.key;
    const bool given = std::ranges::any_of(
        changes, [&](const can::Change& other) { return other.first.key == key; });
    // Other objects may need several values, one after the other, as the controlword.
    if (given && change.first.parameter != nullptr) {
      throw files::UserError(fmt::format("{}: given twice", change.first.parameter->path.text()));
    }
    changes.push_back(std::move(change));
  }
  return changes;
}

void change(Remote& remote, const std::vector<can::Change>& changes, const Common& common) {
  const std::vector<can::Bytes> before =
      common.quiet ? std::vector<can::Bytes>() : can::values_before(remote, changes);
  remote.change(changes);
  say(common, [&] { return can::changed_text(changes, before); });
}

void dump(Remote& remote, const std::string& out, const Common& /*common*/) {
  files::OutputFile file(out);
  file.write(fmt::format("# Parameters of node {} on {}.\n\n", remote.node(),
                         files::printable(remote.bus().name())));
  file.write(text::to_toml(can::read_settings(remote)));
  file.commit();
}

std::vector<can::Difference> differences(Remote& remote, const std::string& path) {
  const Settings<double> node = can::read_settings(remote);
  return can::differences(can::file_settings(path, node), node);
}

void restore(Remote& remote, const std::string& path, const Common& common) {
  const auto all = differences(remote, path);
  can::restore(remote, all);
  say(common, [&] { return can::restored_text(all, common.units); });
  print(fmt::format("{} parameter{} changed\n", all.size(), all.size() == 1 ? "" : "s"));
}

void diff(Remote& remote, const std::string& path, const Common& common) {
  const auto all = differences(remote, path);
  print(can::differences_text(all, common.units));
  // As with diff(1), the exit status 1 means that there are differences.
  if (!all.empty()) {
    throw CLI::RuntimeError(1);
  }
}

// Motion.

struct StepArguments {
  can::StepPlan plan;
  std::string runs = "can-steps";
  std::string report;
  unsigned overlay = 4;
};

/// The files of earlier runs, the newest first.
std::vector<std::filesystem::path> earlier_runs(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("step-") && name.ends_with(".csv")) {
      files.push_back(entry.path());
    }
  }
  std::ranges::sort(files, std::ranges::greater());
  return files;
}

void step(Remote& remote, const StepArguments& a, Units units) {
  files::prepare_folder("--runs", a.runs);
  const auto before = earlier_runs(a.runs);
  // Earlier runs are read before anything moves, so that an unreadable file stops the test early.
  std::vector<can::StepRun> runs;
  for (std::size_t i = 0; i < std::min<std::size_t>(before.size(), a.overlay); ++i) {
    runs.push_back(can::load_step(before[i].string()));
  }
  const auto gains = can::read_gains(remote);
  runs.insert(runs.begin(), can::run_step(remote, a.plan));
  runs.front().gains = gains;
  const unsigned number =
      before.empty() ? 1
                     : 1 + static_cast<unsigned>(std::strtoul(
                               before.front().stem().string().substr(5).c_str(), nullptr, 10));
  std::vector<std::string> names{fmt::format("step-{:04}", number)};
  files::OutputFile file((std::filesystem::path(a.runs) / (names[0] + ".csv")).string());
  file.write(can::step_csv(runs[0]));
  file.commit();
  for (std::size_t i = 0; i + 1 < runs.size(); ++i) {
    names.push_back(before[i].stem().string());
  }
  print(can::step_text(runs, names, units));
  if (!a.report.empty()) {
    can::write_step_report(a.report, runs, names, units);
  }
}

void record(Remote& remote, const can::RecordingPlan& plan, const std::string& out,
            double patience_s) {
  can::arm_recorder(remote, plan);
  can::wait_for_recorder(remote, plan, patience_s);
  hal::TraceFile file(
      out,
      {"host-sim can record", fmt::format("node {} on {}", remote.node(), remote.bus().name())},
      std::vector(1 + plan.signals.size(), hal::mcap::Kind::number));
  const can::Recording recording = can::read_recording(remote, plan);
  file.write(can::to_csv(recording));
  file.commit();
  can::require_complete(recording, plan, out);
}

void explain(const std::shared_ptr<Common>& common, const std::string& name) {
  Fault fault = text::find_fault(name);
  if (!name.empty() && fault == Fault::none) {
    throw files::UserError(fmt::format("{}: no such fault; `host-sim explain` lists them", name));
  }
  if (name.empty()) {
    Session session(*common);
    fault = can::first_cause(session.remote());
    if (fault == Fault::none) {
      print(fmt::format("node {} has no fault\n", common->node));
      return;
    }
  }
  print(text::explain_fault(fault));
}

void add_network_commands(CLI::App& can, const std::shared_ptr<Common>& common) {
  auto seconds = std::make_shared<double>(0.3);
  add(can, "scan", "Lists the nodes of the bus.", [=] { scan(*common, *seconds); })
      ->add_option("--listen", *seconds, "time to wait for heartbeats, s")
      ->capture_default_str()
      ->check(seconds_of(0, 3600));
  auto listen_s = std::make_shared<double>(1e6);
  add(can, "listen", "Prints every frame on the bus in words.", [=] { listen(*common, *listen_s); })
      ->add_option("--for", *listen_s, "duration, s; default: 1000000 s, 11 days")
      ->check(seconds_of(0, 1e6));
  add_plain(can, common, "info", "Prints identity, versions, states, loop and bus of a node.",
            [](Remote& remote, const Common& c) { print(can::info_text(remote, c.units)); });
  add_plain(can, common, "faults",
            "Prints faults, their first cause, and what blocks or limits the output.",
            [](Remote& remote, const Common&) { print(can::faults_text(remote)); });
  add_plain(can, common, "changes",
            "Prints the last accepted and refused writes, the newest at the end.",
            [](Remote& remote, const Common&) { print(can::changes_text(remote)); });
  auto name = std::make_shared<std::string>();
  add(can, "explain", "Says what a fault means and what to check.", [=] {
    explain(common, *name);
  })->add_option("FAULT", *name, "name or code; default: the node's first cause");
}

void add_trial_commands(CLI::App& can, const std::shared_ptr<Common>& common) {
  auto values = std::make_shared<std::vector<std::string>>();
  auto for_s = std::make_shared<double>(30);
  CLI::App* attempt = add(
      can, "try", "Puts parameters in force together, for a time: then they are as before.", [=] {
        const std::vector<can::Change> changes = changes_of(*values);
        Session session(*common);
        std::string said = can::begin_trial(session.remote(), changes, *for_s);
        say(*common, [&] { return said; });
      });
  attempt->add_option("NAME VALUE | NAME=VALUE", *values, "as for `set`; parameters only")
      ->required();
  attempt->add_option("--for", *for_s, "duration of the trial, s")
      ->capture_default_str()
      ->check(seconds_of(0.1, 3600));
  add_plain(can, common, "keep",
            "Makes the trial's values stay; `store` saves them for the next start.",
            [](Remote& remote, const Common& c) {
              std::string said = can::keep_trial(remote);
              say(c, [&] { return said; });
            });
  add_plain(can, common, "revert", "Takes back at once what is on trial.",
            [](Remote& remote, const Common& c) {
              std::string said = can::revert_trial(remote);
              say(c, [&] { return said; });
            });
}

void add_object_commands(CLI::App& can, const std::shared_ptr<Common>& common) {
  auto names = std::make_shared<std::vector<std::string>>();
  add(can, "get", "Reads objects: parameters and live values by name, others by INDEX:SUB.",
      [=] {
        Session session(*common);
        get(session.remote(), *names, common->units);
      })
      ->add_option(
          "NAME", *names,
          "with its unit, for the number alone: strain.proportional_W, wire_temperature_degC; "
          "without, for name, unit and number in that of --units: wire_temperature; 6041")
      ->required();
  auto values = std::make_shared<std::vector<std::string>>();
  add(can, "set", "Writes objects; several parameters take effect together, or none does.",
      [=] {
        const std::vector<can::Change> changes = changes_of(*values);
        Session session(*common);
        change(session.remote(), changes, *common);
      })
      ->add_option("NAME VALUE | NAME=VALUE", *values,
                   "an object and its value in any unit of its kind: strain.proportional_W 0.5, "
                   "limits.temperature=120degC")
      ->required();
  add_trial_commands(can, common);
  const auto with_file = [&](const char* command, const char* meaning, const char* option,
                             void (*run)(Remote&, const std::string&, const Common&)) {
    auto file = std::make_shared<std::string>();
    add(can, command, meaning,
        [=] {
          Session session(*common);
          run(session.remote(), *file, *common);
        })
        ->add_option(option, *file, "TOML, as `host-sim describe settings` gives it")
        ->required();
  };
  with_file("dump", "Writes all parameters to a settings file; - is standard output.", "FILE",
            dump);
  with_file("restore", "Writes the parameters that differ from a settings file, as one set.",
            "FILE", restore);
  with_file("diff",
            "Compares a settings file (left) with the node (right); status 1 if they differ.",
            "FILE", diff);
  add_plain(can, common, "store",
            "Stores parameters and communication settings over a reset (1010h).",
            [](Remote& remote, const Common& c) {
              remote.store();
              say(c, can::stored_text);
            });
}

void add_watch_commands(CLI::App& can, const std::shared_ptr<Common>& common) {
  auto plan = std::make_shared<can::WatchPlan>();
  auto once = std::make_shared<bool>(false);
  CLI::App* watch =
      add(can, "watch", "Shows live values; on a terminal as a table that is redrawn.", [=] {
        if (*once) {
          plan->count = 1;
        }
        plan->units = common->units;
        Session session(*common);
        const bool in_place = plan->count == 0 && isatty(STDOUT_FILENO) != 0;
        can::watch(
            session.remote(), *plan, in_place,
            [=](const std::string& text) {
              if (in_place) {
                files::clear_terminal();
              }
              print(text);
            },
            [=](const std::string& line) { say(*common, [&] { return line; }); });
      });
  watch->add_option(
      "NAME", plan->names,
      "objects, as for `get`; without a unit in that of --units; default: a selection");
  watch->add_option("--period", plan->period_s, "time between rows, s")
      ->capture_default_str()
      ->check(seconds_of(0.01, 3600));
  watch->add_option("--count", plan->count, "number of rows; default: for ever");
  watch->add_flag("--once", *once, "prints one row and ends");
  watch->add_option("--plot", plan->plot, "draws the curve of this object as text");

  auto record_plan = std::make_shared<can::RecordingPlan>();
  auto out = std::make_shared<std::string>();
  auto patience_s = std::make_shared<double>(60);
  record_plan->signals = {"position_m", "setpoint", "wire_temperature_K", "drive_current_A",
                          "resistance_ohm"};
  CLI::App* record_command =
      add(can, "record", "Records signals at the rate of the loop into a CSV or MCAP file.", [=] {
        Session session(*common);
        record(session.remote(), *record_plan, *out, *patience_s);
      });
  record_command
      ->add_option(
          "--signals", record_plan->signals,
          "up to 8 live values: SI names, such as wire_temperature_K, with or without `live.`")
      ->delimiter(',');
  record_command->add_option("--seconds", record_plan->seconds, "duration, s")
      ->capture_default_str()
      ->check(seconds_of(0.001, 86400));
  record_command
      ->add_option("--before", record_plan->before_s,
                   "part of the duration that lies before the trigger, s")
      ->check(seconds_of(0, 86400));
  record_command->add_option("--trigger", record_plan->trigger,
                             "SIGNAL>LEVEL or SIGNAL<LEVEL, in SI");
  record_command->add_option("--patience", *patience_s, "longest wait for the trigger, s")
      ->capture_default_str()
      ->check(seconds_of(0, 1e6));
  record_command
      ->add_option("--out", *out,
                   "CSV file, or MCAP if the name ends in .mcap; - is standard output")
      ->required();
}

void add_motion_commands(CLI::App& can, const std::shared_ptr<Common>& common) {
  add_plain(can, common, "start",
            "NMT: makes the node operational, so that it exchanges process data.",
            [](Remote& remote, const Common& c) {
              remote.nmt(can::NmtCommand::start);
              std::string said = can::started_text(remote);
              say(c, [&] { return said; });
            });
  add_plain(can, common, "stop",
            "NMT: stops the node's communication except NMT and heartbeat; heat ends (6007h).",
            [](Remote& remote, const Common& c) {
              remote.nmt(can::NmtCommand::stop);
              say(c, [&] { return can::stopped_text(remote); });
            });
  add_plain(can, common, "reset", "NMT: restarts the node, and waits for its start; heat ends.",
            [](Remote& remote, const Common& c) {
              remote.nmt(can::NmtCommand::reset_node);
              std::string said = can::restarted_text(remote);
              say(c, [&] { return said; });
            });
  add_plain(can, common, "enable",
            "Enables the drive through the states of CiA 402; it may then heat the wire.",
            [](Remote& remote, const Common& c) {
              remote.enable();
              say(c, [&] { return can::enabled_text(remote); });
            });
  add_plain(can, common, "disable", "Disables the drive: current off, the wire relaxes.",
            [](Remote& remote, const Common& c) {
              remote.disable();
              say(c, [&] { return can::disabled_text(remote, c.units); });
            });
  add_plain(can, common, "reset-faults", "Acknowledges faults; disables the drive.",
            [](Remote& remote, const Common& c) {
              const FaultSet before = c.quiet ? FaultSet() : can::latched_faults(remote);
              remote.reset_faults();
              say(c, [&] { return can::faults_reset_text(remote, before); });
            });
  auto hold_s = std::make_shared<double>(1e6);
  CLI::App* hold =
      add(can, "hold", "Keeps an enabled drive enabled, as a master that is there does.",
          [common, hold_s] {
            Session session(*common);
            session.remote().hold(*hold_s);
          });
  hold->footer(
      "Who types commands by hand leaves it running in a second terminal: get and watch, set and\n"
      "try of parameters are no commands and do not renew heat.");
  hold->add_option("--for", *hold_s, "duration, s; default: 1000000 s, 11 days")
      ->check(seconds_of(0, 1e6));
  auto target = std::make_shared<std::string>();
  auto patience_s = std::make_shared<double>(10);
  CLI::App* move = add(
      can, "move", "Moves to a position (Profile position) and waits until it is reached.", [=] {
        const std::int32_t target_um = can::position_um(*target, common->units);
        Session session(*common);
        can::require_allowed(session.remote(), target_um, *target, common->units);
        const std::int64_t start_us = session.bus().now_us();
        session.remote().move(target_um, *patience_s);
        const double took_s = static_cast<double>(session.bus().now_us() - start_us) * 1e-6;
        say(*common,
            [&] { return can::moved_text(session.remote(), target_um, took_s, common->units); });
      });
  move->add_option("POSITION", *target,
                   "contraction: 0.8mm, or in um alone: 1000; with --units si always with a unit")
      ->required();
  move->add_option("--patience", *patience_s, "longest wait, s")
      ->capture_default_str()
      ->check(seconds_of(0, 1e6));

  auto a = std::make_shared<StepArguments>();
  CLI::App* step_command =
      add(can, "step",
          "Makes a step there and back; prints its figures beside those of earlier runs.", [=] {
            Session session(*common);
            step(session.remote(), *a, common->units);
          });
  step_command
      ->add_option("--amplitude-um", a->plan.amplitude_um, "size of the step, um of contraction")
      ->capture_default_str();
  step_command
      ->add_option("--seconds", a->plan.seconds,
                   "duration of the step there, and of the step back, s")
      ->capture_default_str()
      ->check(seconds_of(0.2, 600));
  step_command->add_option("--runs", a->runs, "folder that keeps the runs")->capture_default_str();
  step_command
      ->add_option("--overlay", a->overlay, "number of earlier steps to compare the new one with")
      ->capture_default_str();
  step_command->add_option("--report", a->report, "HTML page with pictures");
}

}  // namespace

void add_can_command(CLI::App& app) {
  CLI::App* can =
      app.add_subcommand("can", "Talks to a servo over CAN: reads, tunes, moves, records.");
  auto common = std::make_shared<Common>();
  can->require_subcommand(1);
  can->add_option("--can", common->can, "can0, vcan0, ...; or udp, udp:GROUP[:PORT]")->required();
  can->add_option("--node", common->node, "node-id")
      ->capture_default_str()
      ->check(CLI::Range(1, 127));
  can->add_option("--key", common->key, "key of an access level (2003h)");
  can->add_option("--timeout", common->timeout_s, "longest wait for an answer, s")
      ->capture_default_str()
      ->check(seconds_of(0.01, 60));
  add_units_option(*can, common->units, "units of what is shown");
  can->add_flag("--quiet", common->quiet, "prints no line about the new state");
  add_network_commands(*can, common);
  add_object_commands(*can, common);
  add_watch_commands(*can, common);
  add_motion_commands(*can, common);
  // Not before: each command would have it.
  can->footer(about_gains);
  for (const char* const command : {"set", "try", "step"}) {
    can->get_subcommand(command)->footer(about_gains);
  }
}

}  // namespace smaservo::can
