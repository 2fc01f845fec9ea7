#include "host-sim/commands/commands.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fmt/format.h>
#include <utility>

#include "host-sim/campaign/campaign_command.hpp"
#include "host-sim/can/can_command.hpp"
#include "host-sim/choose/choose_command.hpp"
#include "host-sim/commission/commission_command.hpp"
#include "host-sim/convert/convert_command.hpp"
#include "host-sim/describe/describe_command.hpp"
#include "host-sim/evaluate/evaluate_command.hpp"
#include "host-sim/fmu/export_fmu_command.hpp"
#include "host-sim/identify/identify_command.hpp"
#include "host-sim/inspect/inspect_command.hpp"
#include "host-sim/page/page_command.hpp"
#include "host-sim/papers/compare/compare_command.hpp"
#include "host-sim/papers/figures/figures_command.hpp"
#include "host-sim/plan/plan_command.hpp"
#include "host-sim/record/record_command.hpp"
#include "host-sim/replay/replay_command.hpp"
#include "host-sim/simulate/simulate_command.hpp"
#include "host-sim/tune/tune_command.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/similar.hpp"
#include "model/files/wrapped.hpp"

namespace smaservo::commands {
namespace {

constexpr int wrong_command_line = 2;

std::vector<std::string> names_of_commands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

}  // namespace

int run_host_sim(int argc, char** argv) {
  CLI::App app{"Replays, simulates and describes shape-memory-alloy wires on a PC.", "host-sim"};
  app.set_version_flag("--version", SMASERVO_VERSION);
  // CLI11's own message, made printable because it quotes the command line.
  app.failure_message([](const CLI::App*, const CLI::Error& error) {
    return files::printable(error.what()) + "\nRun with --help for more information.\n";
  });
  // Set before the commands are added, which inherit it.
  app.formatter_fn([](const CLI::App* of, std::string name, CLI::AppFormatMode mode) {
    return files::wrapped_help(CLI::Formatter().make_help(of, std::move(name), mode));
  });
  app.require_subcommand(1);
  plan::add_calibrate_plan_command(app);
  campaign::add_campaign_command(app);
  can::add_can_command(app);
  choose::add_choose_command(app);
  commission::add_commission_command(app);
  compare::add_compare_command(app);
  convert::add_convert_command(app);
  describe::add_describe_command(app);
  evaluate::add_evaluate_command(app);
  describe::add_explain_command(app);
  fmu::add_export_fmu_command(app);
  figures::add_figures_command(app);
  identify::add_identify_command(app);
  inspect::add_inspect_command(app);
  page::add_page_command(app);
  record::add_record_command(app);
  replay::add_replay_command(app);
  replay::add_replay_device_command(app);
  simulate::add_simulate_command(app);
  tune::add_tune_command(app);
  describe::add_wires_command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& result) {
    return result.get_exit_code();
  } catch (const CLI::ParseError& error) {
    if (argc > 1 && *argv[1] != '-' && app.get_subcommands().empty()) {
      files::complain("host-sim",
                      fmt::format("{}: no such command{}", argv[1],
                                  files::did_you_mean(argv[1], names_of_commands(app))));
    }
    return app.exit(error) == 0 ? 0 : wrong_command_line;
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    throw files::UserError(fmt::format("standard output: {}", std::strerror(errno)));
  }
  return 0;
}

}  // namespace smaservo::commands
