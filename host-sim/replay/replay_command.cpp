#include "host-sim/replay/replay_command.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>

#include "firmware/text/settings_file.hpp"
#include "host-sim/checks/findings.hpp"
#include "host-sim/replay/ci/expectations.hpp"
#include "host-sim/replay/ci/outcome.hpp"
#include "host-sim/replay/observers.hpp"
#include "host-sim/replay/replay.hpp"
#include "host-sim/replay/report.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"
#include "model/files/text_table.hpp"
#include "model/units.hpp"

namespace smaservo::replay {
namespace {

struct ReplayArguments {
  ReplayOptions options;
  std::string wire{files::default_wire};
  std::vector<std::string> settings;
  std::vector<std::string> traces;
  std::string report;
  Units units = Units::bench;
  std::optional<std::string> fail_above, expect;  // an empty text is refused, not ignored
  std::string junit, summary;
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

/// What the options say beyond the names of files. Throws UserError.
void read_options(ReplayArguments& a) {
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
}

/// Throws UserError where an output would be written over an input or another output.
void check_outputs(const ReplayArguments& a) {
  const std::vector<std::pair<const char*, const std::string*>> outputs{{"--out", &a.options.out},
                                                                        {"--report", &a.report},
                                                                        {"--junit", &a.junit},
                                                                        {"--summary", &a.summary}};
  std::vector<std::string> inputs = a.traces;
  inputs.push_back(a.expect.value_or(""));
  if (a.wire.ends_with(".toml")) {
    inputs.push_back(a.wire);
  }
  const char* standard = nullptr;
  for (const auto& [option, file] : outputs) {
    const bool of_one = file == &a.options.out || file == &a.report;
    if (of_one && !file->empty() && a.traces.size() > 1) {
      throw files::UserError(fmt::format(
          "{}: is of one trace, and {} are given; replay each trace by a command of its own for it",
          option, a.traces.size()));
    }
    for (const std::string& input : inputs) {
      refuse_to_overwrite(input, *file);
    }
    if (*file == "-") {
      if (standard != nullptr) {
        throw files::UserError(
            fmt::format("{} -: standard output is taken by {}", option, standard));
      }
      standard = option;
    }
    inputs.push_back(*file);
  }
}

/// Where the numbers are printed: where a file takes standard output, they must not mix with it.
std::FILE* stream(const ReplayArguments& a) {
  const bool taken = a.options.out == "-" || a.report == "-" || a.junit == "-" || a.summary == "-";
  return taken ? stderr : stdout;
}

/// What came of all traces.
struct Replays {
  std::vector<Outcome> outcomes;
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
};

/// A replay as the options want it printed, or collected for JSON.
void show(const ReplayArguments& a, const Outcome& outcome, const ReplayResult& result,
          Replays& all) {
  if (a.json) {
    all.json.push_back(summary_object(a.options, result));
    if (outcome.judged) {
      all.json.back()["misses"] = outcome.misses;
    }
    return;
  }
  files::print((all.outcomes.empty() ? "" : "\n") + summary(a.options, result), stream(a));
}

/// Replays and judges one trace; what goes wrong is said and kept.
void replay_trace(ReplayArguments& a, const std::string& trace, std::span<const Bounds> bounds,
                  Replays& all) {
  const auto start = std::chrono::steady_clock::now();
  Outcome outcome;
  outcome.trace = trace;
  a.options.trace = trace;
  try {
    ReplayResult replayed = replay(a.options);
    if (!a.report.empty()) {
      write_report(a.report, a.options, replayed, a.units);
    }
    replayed.series = report::ReplaySeries();
    const ReplayResult& result = outcome.result.emplace(std::move(replayed));
    judge(outcome, result, bounds);
    show(a, outcome, result, all);
    check_result(a.options, result);
  } catch (const files::NoResult& failure) {
    outcome.lost = failure.what();
  } catch (const std::exception& error) {
    outcome.errors.emplace_back(error.what());
  }
  if (a.json && (a.traces.size() > 1 || outcome.judged) && !outcome.errors.empty()) {
    if (!outcome.result) {
      all.json.push_back({{"trace", trace}});
    }
    all.json.back()["mistakes"] = outcome.errors;
  }
  std::fflush(stdout);
  for (const std::string& error : outcome.errors) {
    files::complain("host-sim", error);
  }
  for (const std::string& miss : outcome.misses) {
    files::complain("host-sim", fmt::format("{}: {}", outcome.name(), miss));
  }
  if (!outcome.lost.empty()) {
    files::complain("host-sim", outcome.lost);
  }
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  outcome.elapsed_s = elapsed.count();
  all.outcomes.push_back(std::move(outcome));
}

void write_file(const std::string& path, const std::string& text) {
  if (!path.empty()) {
    files::OutputFile file(path);
    file.write(text);
    file.commit();
  }
}

void run(ReplayArguments& a) {
  read_options(a);
  check_outputs(a);
  std::vector<Bounds> common;
  if (a.fail_above) {
    common.push_back(parse_fail_above(*a.fail_above));
  }
  std::optional<Expectations> expectations;
  if (a.expect) {
    expectations.emplace(*a.expect, a.traces, a.options.observers);
  }
  const auto began = std::chrono::system_clock::now();
  Replays all;
  for (const std::string& trace : a.traces) {
    std::vector<Bounds> bounds = common;
    if (expectations) {
      bounds.push_back(expectations->of(trace));
    }
    replay_trace(a, trace, bounds, all);
  }
  if (a.json && !all.json.empty()) {
    files::print(files::json_text(a.traces.size() == 1 ? all.json.front() : all.json), stream(a));
  }
  write_file(a.junit, junit_xml(all.outcomes, began));
  write_file(a.summary, summary_markdown(all.outcomes));
  if (const int status = exit_status(all.outcomes); status != 0) {
    throw CLI::RuntimeError(status);
  }
}

void add_ci_options(CLI::App& command, ReplayArguments& a) {
  command.add_option("--fail-above", a.fail_above,
                     "mean=1,p95=3,max=10 or some of these: greatest errors of the first observer, "
                     "in % of the nominal stroke; above them the exit status is 1");
  command.add_option("--expect", a.expect,
                     "TOML file with bounds for each trace, by its file name");
  command.add_option("--junit", a.junit,
                     "how each trace has ended, as JUnit XML; - for standard output");
  command.add_option("--summary", a.summary, "the same as a Markdown table; - for standard output");
}

}  // namespace

void add_replay_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "replay", "Runs the estimation loop on recorded traces and prints its errors.");
  auto a = std::make_shared<ReplayArguments>();
  std::vector<std::string> observers;
  for (const ObserverKind& kind : observer_kinds()) {
    observers.emplace_back(kind.name);
  }
  a->options.observers = observers;
  command->add_option("TRACE", a->traces, "CSV or MCAP files, - for standard input")->required();
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
  add_report_options(*command, a->report, a->units);
  command->add_flag("--json", a->json, "print the numbers as JSON; of several traces as a list");
  add_ci_options(*command, *a);
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
