#include <fmt/format.h>
#include <memory>

#include "firmware/bench/device_replay.hpp"
#include "firmware/text/settings_file.hpp"
#include "host-sim/replay/replay_command.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::replay {
namespace {

struct ReplayDeviceArguments {
  bench::DeviceReplayOptions options;
  std::string settings;
  bool allow_differences = false;
  std::optional<double> tolerance;
  std::optional<double> period_s;
};

void run_device(ReplayDeviceArguments& a) {
  require("--tolerance", a.tolerance, 0, 1);
  require("--period-s", a.period_s, 1e-6, 1e6);
  bench::DeviceReplayOptions& options = a.options;
  options.settings = text::load_settings_file(a.settings);
  options.tolerance = a.tolerance.value_or(0);
  options.trace_options.period_s = a.period_s.value_or(0);
  refuse_to_overwrite(options.trace, options.out);
  refuse_to_overwrite(a.settings, options.out);
  const bench::DeviceReplayResult result = bench::replay_device(options);
  files::print(summary(options, result), options.out == "-" ? stderr : stdout);
  if (!bench::agrees(result) && !a.allow_differences) {
    throw files::UserError(fmt::format("{}: the outputs differ from those in the trace{}",
                                       options.trace,
                                       a.tolerance ? " by more than the tolerance" : ""));
  }
}

}  // namespace

void add_replay_device_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "replay-device",
      "Runs the whole device with the commands of a trace and compares its outputs.");
  auto a = std::make_shared<ReplayDeviceArguments>();
  command->add_option("SETTINGS", a->settings, "settings of the device, a TOML file")->required();
  command->add_option("TRACE", a->options.trace, "CSV or MCAP file, - for standard input")
      ->required();
  command->add_option("--out", a->options.out,
                      "log and new outputs as CSV, or as MCAP if the name ends in .mcap; - for "
                      "standard output");
  command->add_flag("--lenient", a->options.trace_options.lenient,
                    "skip and count bad rows instead of refusing them");
  command->add_option("--period-s", a->period_s, "time between rows of a trace without time, s");
  command->add_option("--column", a->options.trace_options.renames, column_help)
      ->allow_extra_args(false);
  command->add_flag("--allow-differences", a->allow_differences,
                    "exit with 0 even if the outputs differ from the trace's");
  command
      ->add_option("--tolerance", a->tolerance,
                   "allowed difference of numbers, as a share of their range in the trace, for "
                   "traces of another machine or compiler")
      ->excludes("--allow-differences");
  command->callback([a] { run_device(*a); });
}

}  // namespace smaservo::replay
