#include "host-sim/record/record_command.hpp"

#include <fmt/format.h>
#include <memory>

#include "host-sim/can/commands/session.hpp"
#include "host-sim/checks/findings.hpp"
#include "host-sim/end_by_signal.hpp"
#include "host-sim/options.hpp"
#include "host-sim/record/bus_run.hpp"
#include "host-sim/record/card/card_keys.hpp"
#include "host-sim/record/check.hpp"
#include "host-sim/record/record.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::record {
namespace {

struct RecordArguments {
  std::string card, out, check, name;
  bool new_card = false;
  std::vector<std::string> runs, columns, allowed;
  std::optional<double> period_s, load_N, stress_MPa;
  can::Common common;
  can::RecordingPlan plan;
  std::vector<std::string> signals{"strain"};
  double seconds = 0, patience_s = 60;
};

void need(const std::string& value, const char* option) {
  if (value.empty()) {
    throw CLI::RequiredError(option);
  }
}

void check(const RecordArguments& a) {
  Checked checked;
  {
    const EndBySignal guard;
    checked = check_folder(a.check, a.allowed);
  }
  for (const std::string& note : checked.notes) {
    files::complain("host-sim", note);
  }
  for (const std::string& fault : checked.faults) {
    files::complain("host-sim", fault);
  }
  if (!checked.faults.empty()) {
    throw files::UserError(fmt::format("{}: {} {}, named above", a.check, checked.faults.size(),
                                       checked.faults.size() == 1 ? "fault" : "faults"));
  }
  files::print(fmt::format("{}: {} {}, {} rows: nothing is wrong\n", files::printable(a.check),
                           checked.runs, checked.runs == 1 ? "run" : "runs", checked.rows));
}

void record_tables(const RecordArguments& a) {
  require("--period-s", a.period_s, 1e-6, 1e6);
  require("--load-N", a.load_N, 0, 1e5);
  require("--stress-MPa", a.stress_MPa, 0, 1e4);
  if (!a.name.empty() && a.runs.size() > 1) {
    throw files::UserError("--run: names one run, and several are given");
  }
  RecordTask task{a.card, a.out, {}};
  for (const std::string& path : a.runs) {
    task.runs.push_back(
        {a.name,
         {path, path, a.columns, a.period_s.value_or(0), a.load_N, a.stress_MPa, a.allowed}});
  }
  files::print(record_runs(task));
}

void record_servo(RecordArguments& a) {
  a.plan.signals = signals_with(a.signals);
  a.plan.seconds = a.seconds;
  can::Recording recording;
  const BusTask task{a.card, a.out, a.name, a.allowed,
                     fmt::format("node {} on {}", a.common.node, a.common.can)};
  const std::string done = record_bus(task, [&] {
    can::Session session(a.common);
    BusRun run = record_from_bus(session.remote(), a.plan, a.patience_s, [&] {
      if (!a.plan.trigger.empty()) {
        files::complain("host-sim", fmt::format("waiting for {}", a.plan.trigger));
      }
    });
    recording = std::move(run.recording);
    return Recorded{std::move(run.csv), run.left_out};
  });
  files::print(done);
  can::require_complete(recording, a.plan, a.out);
}

void run_record(RecordArguments& a) {
  if (a.new_card) {
    files::print(empty_card());
    return;
  }
  if (!a.check.empty()) {
    check(a);
    return;
  }
  need(a.card, "--card");
  need(a.out, "--out");
  if (a.common.can.empty()) {
    need(a.runs.empty() ? "" : a.runs.front(), "RUN or --can");
    record_tables(a);
  } else {
    need(a.seconds > 0 ? "given" : "", "--seconds");
    record_servo(a);
  }
}

void add_table_options(CLI::App& command, RecordArguments& a) {
  command.add_option("RUN", a.runs, "recordings as tables or MCAP files, of any bench");
  command.add_option("--column", a.columns, column_help)->allow_extra_args(false);
  command.add_option("--period-s", a.period_s, "time between rows of a table without time, s");
  command.add_option("--load-N", a.load_N, "load of runs without a load, N");
  command.add_option("--stress-MPa", a.stress_MPa, "the same as a stress, MPa")
      ->excludes("--load-N");
}

void add_bus_options(CLI::App& command, RecordArguments& a) {
  CLI::Option* bus = command.add_option("--can", a.common.can,
                                        "a servo's bus: can0, vcan0, ...; udp[:GROUP[:PORT]]");
  for (const char* const table : {"RUN", "--column", "--period-s", "--load-N", "--stress-MPa"}) {
    bus->excludes(table);
  }
  command.add_option("--node", a.common.node, "node-id")
      ->capture_default_str()
      ->check(CLI::Range(1, 127))
      ->needs(bus);
  command.add_option("--key", a.common.key, "key of an access level (2003h)")->needs(bus);
  command.add_option("--timeout", a.common.timeout_s, "longest wait for an answer, s")
      ->capture_default_str()
      ->check(can::seconds_of(0.01, 60))
      ->needs(bus);
  command.add_option("--seconds", a.seconds, "duration of the run, s")
      ->check(can::seconds_of(0.001, 86400))
      ->needs(bus);
  command
      .add_option("--signals", a.signals, "up to 5 live values besides current, voltage, stress")
      ->delimiter(',')
      ->capture_default_str()
      ->needs(bus);
  command.add_option("--trigger", a.plan.trigger, "SIGNAL>LEVEL or SIGNAL<LEVEL, in SI")
      ->needs(bus);
  command.add_option("--before", a.plan.before_s, "time of the run before the trigger, s")
      ->check(can::seconds_of(0, 86400))
      ->needs(bus);
  command.add_option("--patience", a.patience_s, "longest wait for the trigger, s")
      ->capture_default_str()
      ->check(can::seconds_of(0, 1e6))
      ->needs(bus);
}

}  // namespace

void add_record_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "record", "Makes a folder of runs and a data card, which others can replay.");
  auto a = std::make_shared<RecordArguments>();
  CLI::Option* new_card =
      command->add_flag("--new-card", a->new_card, "prints a data card to fill in");
  CLI::Option* check_option =
      command->add_option("--check", a->check, "judges a folder: card, checksums, every run");
  CLI::Option* card = command->add_option("--card", a->card, "data card, a TOML file");
  CLI::Option* out =
      command->add_option("--out", a->out, "folder to make, or, with this card, to add to");
  CLI::Option* name = command->add_option("--run", a->name, "name of the run; default: its file's");
  add_table_options(*command, *a);
  add_bus_options(*command, *a);
  command->add_option("--allow", a->allowed, checks::allow_help)->allow_extra_args(false);
  new_card->excludes(check_option);
  for (CLI::Option* const other :
       {card, out, name, command->get_option("RUN"), command->get_option("--can"),
        command->get_option("--column"), command->get_option("--period-s"),
        command->get_option("--load-N"), command->get_option("--stress-MPa")}) {
    new_card->excludes(other);
    check_option->excludes(other);
  }
  command->callback([a] { run_record(*a); });
}

}  // namespace smaservo::record
