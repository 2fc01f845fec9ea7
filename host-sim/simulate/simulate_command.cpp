#include "host-sim/simulate/simulate_command.hpp"

#include <fmt/format.h>
#include <memory>

#include "firmware/bench/scenario/scenario.hpp"
#include "hal/recording/trace_file.hpp"
#include "host-sim/simulate/closed_loop_report.hpp"
#include "host-sim/simulate/simulate.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::simulate {
namespace {

struct SimulateArguments {
  std::string scenario, out, report;
  Units units = Units::bench;
};

void run_loop(const SimulateArguments& a) {
  const bench::ClosedLoopScenario scenario = bench::load_closed_loop(a.scenario);
  const LoopRunResult result =
      run_closed_loop(scenario, {.out = a.out, .record = !a.report.empty()});
  if (!a.report.empty()) {
    write_report(a.report, scenario, result, a.units);
  }
  // If a file is written to standard output, the summary must not mix with it.
  const bool taken = a.out == "-" || a.report == "-";
  files::print(summary(scenario, result), taken ? stderr : stdout);
}

void run(const SimulateArguments& a) {
  refuse_to_overwrite(a.scenario, a.out);
  refuse_to_overwrite(a.scenario, a.report);
  refuse_to_overwrite(a.out, a.report);
  if (bench::is_closed_loop(a.scenario)) {
    run_loop(a);
    return;
  }
  if (!a.report.empty()) {
    throw files::UserError(
        fmt::format("{}: has no [device], so there is nothing to report; replay "
                    "--report shows what an observer makes of the trace",
                    a.scenario));
  }
  const bench::Scenario scenario = bench::load_scenario(a.scenario);
  hal::TraceFile file(a.out.empty() ? "-" : a.out, {"host-sim simulate", a.scenario});
  simulate(scenario, file);
  file.commit();
}

}  // namespace

void add_simulate_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "simulate", "Makes a trace of a simulated wire for observers, or runs a device on the wire.");
  auto a = std::make_shared<SimulateArguments>();
  command
      ->add_option("--scenario,SCENARIO", a->scenario,
                   "TOML file; its keys are in host-sim/simulate/README.md")
      ->required();
  command->add_option("--out", a->out,
                      "trace as CSV, or as MCAP if the name ends in .mcap; - is standard output, "
                      "the default without a [device]");
  add_report_options(*command, a->report, a->units, "report as one HTML file; needs a [device]");
  command->callback([a] { run(*a); });
}

}  // namespace smaservo::simulate
