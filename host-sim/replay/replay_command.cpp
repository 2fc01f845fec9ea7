#include "host-sim/replay/replay_command.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <memory>

#include "firmware/text/settings_file.hpp"
#include "host-sim/checks/findings.hpp"
#include "host-sim/replay/observers.hpp"
#include "host-sim/replay/replay.hpp"
#include "host-sim/replay/report.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/units.hpp"

namespace smaservo::replay {
namespace {

struct ReplayArguments {
  ReplayOptions options;
  std::string wire{files::default_wire};
  std::vector<std::string> settings;
  std::string report;
  bool json = false;
  std::optional<double> stress_MPa, ambient_degC;
  std::optional<double> period_s;
};

/// Throws where no estimate can be of use.
void check_result(const ReplayOptions& options, const ReplayResult& result) {
  const std::string name = options.trace == "-" ? "standard input" : options.trace;
  if (!result.open_loop && result.invalid == result.rows) {
    throw files::UserError(
        fmt::format("{}: no row has a valid resistance, so the estimate follows the power alone; "
                    "are length and diameter of {} and the units of current and voltage right?",
                    name, options.wire.name));
  }
  if (result.has_reference &&
      std::ranges::all_of(result.observers, [](const auto& o) { return o.lost; })) {
    throw files::NoResult(fmt::format("{}: all observers were lost", name));
  }
}

void run(ReplayArguments& a) {
  require("--load-N", a.options.load_N, 0, 1e5);
  require("--stress-MPa", a.stress_MPa, 0, 1e4);
  require("--ambient-degC", a.ambient_degC, -100, 200);
  require("--period-s", a.period_s, 1e-6, 1e6);
  if (a.stress_MPa) {
    a.options.stress_Pa = 1e6 * *a.stress_MPa;
  }
  if (a.ambient_degC) {
    a.options.ambient_K = zero_degC_K + *a.ambient_degC;
  }
  a.options.trace_options.period_s = a.period_s.value_or(0);
  std::vector<files::Override> wire;
  for (files::Override& setting : text::parse_settings(a.settings)) {
    (is_run_setting(setting.first) ? a.options.settings : wire).push_back(std::move(setting));
  }
  a.options.wire = files::load_wire(a.wire, wire);
  const auto& names = a.options.observers;
  for (auto name = names.begin(); name != names.end(); ++name) {
    if (std::find(names.begin(), name, *name) != name) {
      throw files::UserError(fmt::format("--observer {}: is given twice", *name));
    }
  }
  refuse_to_overwrite(a.options.trace, a.options.out);
  refuse_to_overwrite(a.options.trace, a.report);
  refuse_to_overwrite(a.options.out, a.report);
  const ReplayResult result = replay(a.options);
  if (!a.report.empty()) {
    write_report(a.report, a.options, result);
  }
  // Where the estimate takes standard output, the summary must not mix with it.
  const bool taken = a.options.out == "-" || a.report == "-";
  files::print(a.json ? summary_json(a.options, result) : summary(a.options, result),
               taken ? stderr : stdout);
  check_result(a.options, result);
}

}  // namespace

void add_replay_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "replay", "Runs the estimation loop on a recorded trace and prints its errors.");
  auto a = std::make_shared<ReplayArguments>();
  std::vector<std::string> observers;
  for (const ObserverKind& kind : observer_kinds()) {
    observers.emplace_back(kind.name);
  }
  a->options.observers = observers;
  command->add_option("TRACE", a->options.trace, "CSV or MCAP file, - for standard input")
      ->required();
  command->add_option("--wire", a->wire, "preset or file that ends in .toml")
      ->capture_default_str();
  command
      ->add_option("--observer", a->options.observers,
                   "the first one writes the estimate; the others are compared with it where the "
                   "trace has a reference")
      ->check(CLI::IsMember(observers))
      ->allow_extra_args(false)
      ->capture_default_str();
  command
      ->add_option("--set", a->settings, "key=value of wire, observer or measurement; repeatable")
      ->allow_extra_args(false);
  command->add_option(
      "--out", a->options.out,
      "estimate as CSV, or as MCAP if the name ends in .mcap; - for standard output");
  command->add_option("--report", a->report, "report as one HTML file");
  command->add_flag("--json", a->json, "print the numbers as JSON");
  command->add_flag("--lenient", a->options.trace_options.lenient,
                    "skip and count bad rows instead of refusing them");
  command->add_option("--load-N", a->options.load_N, "load of a trace without one, N");
  command->add_option("--stress-MPa", a->stress_MPa, "the same as a stress, MPa")
      ->excludes("--load-N");
  command->add_option("--ambient-degC", a->ambient_degC,
                      "first guess of the air; default: the trace's first value, or 25");
  command->add_option("--period-s", a->period_s, "time between rows of a trace without time, s");
  command->add_option("--column", a->options.trace_options.renames, column_help)
      ->allow_extra_args(false);
  command->add_option("--allow", a->options.allowed, checks::allow_help)->allow_extra_args(false);
  // Formerly the command replay-device; whoever still types it is told the new name.
  command
      ->add_option_function<std::string>(
          "--device",
          [](const std::string&) {
            throw CLI::ValidationError(
                "--device", "is a command of its own now: host-sim replay-device SETTINGS TRACE");
          })
      ->expected(0, 1)
      ->group("");
  command->callback([a] { run(*a); });
}

}  // namespace smaservo::replay
