#include "host-sim/inspect/inspect_command.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <memory>

#include "firmware/text/settings_file.hpp"
#include "host-sim/inspect/inspect.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::inspect {
namespace {

struct InspectArguments {
  InspectOptions options;
  std::vector<std::string> traces;
  std::string wire;
  std::vector<std::string> settings;
  std::string report;
  Units units = Units::bench;
  bool json = false;
  std::optional<double> period_s;
};

void run(InspectArguments& a) {
  require("--period-s", a.period_s, 1e-6, 1e6);
  a.options.trace_options.period_s = a.period_s.value_or(0);
  if (!a.report.empty() && a.traces.size() > 1) {
    throw files::UserError("--report: is of one file, and several are given");
  }
  refuse_to_overwrite(a.traces.front(), a.report);
  a.options.wire_given = !a.wire.empty() || !a.settings.empty();
  if (!a.wire.empty()) {
    a.options.wire_words = " --wire " + a.wire;
  }
  for (const std::string& setting : a.settings) {
    a.options.wire_words += " --set " + setting;
  }
  a.options.wire = files::load_wire(a.wire.empty() ? std::string(files::default_wire) : a.wire,
                                    text::parse_settings(a.settings));
  std::vector<Facts> all;
  std::size_t mistaken = 0;
  for (const std::string& trace : a.traces) {
    a.options.trace = trace;
    all.push_back(inspect(a.options));
    const Facts& facts = all.back();
    mistaken += std::ranges::any_of(facts.findings, &checks::Finding::is_error) ? 1U : 0U;
    if (!a.json) {
      files::print((all.size() > 1 ? "\n" : "") + text_of(facts, a.options));
    }
    if (!a.report.empty()) {
      write_report(a.report, facts, a.options, a.units);
    }
    all.back().record = {};
  }
  if (a.json) {
    files::print(json_of(all));
  }
  if (mistaken > 0) {
    throw files::UserError(fmt::format("{} of {} files {} mistakes, named above", mistaken,
                                       all.size(), mistaken == 1 ? "has" : "have"));
  }
}

}  // namespace

void add_inspect_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "inspect", "Shows what files of measurements hold, their mistakes, and what can be done.");
  auto a = std::make_shared<InspectArguments>();
  command->add_option("TRACE", a->traces, "table as text or MCAP file, - for standard input")
      ->required();
  command->add_option("--wire", a->wire,
                      "preset or file that ends in .toml: judges length, load and power, too");
  command->add_option("--set", a->settings, "key=value of the wire; repeatable")
      ->allow_extra_args(false);
  command->add_option("--column", a->options.trace_options.renames, column_help)
      ->allow_extra_args(false);
  command->add_option("--period-s", a->period_s, "time between rows of a trace without time, s");
  command->add_flag("--json", a->json, "print the facts as JSON");
  add_report_options(*command, a->report, a->units, "report with plots as one HTML file");
  command->callback([a] { run(*a); });
}

}  // namespace smaservo::inspect
