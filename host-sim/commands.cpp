#include "host-sim/commands.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>

#include "host-sim/run.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo {
namespace {

constexpr int wrong_command_line = 2;

}  // namespace

void require(const char* option, const std::optional<double>& value, double low, double high) {
  if (value && !(*value >= low && *value <= high)) {
    throw files::UserError(
        fmt::format("{} {}: must be between {} and {}", option, *value, low, high));
  }
}

void refuse_to_overwrite(const std::string& file, const std::string& output) {
  std::error_code missing;
  const bool plain = !file.empty() && !output.empty() && file != "-" && output != "-";
  if (plain && std::filesystem::exists(output, missing) &&
      !std::filesystem::is_regular_file(output, missing)) {
    return;
  }
  if (plain && (file == output || std::filesystem::equivalent(file, output, missing))) {
    throw files::UserError(fmt::format("{}: is the same file as {}", output, file));
  }
}

int run_host_sim(int argc, char** argv) {
  CLI::App app{"Replays, simulates and describes shape-memory-alloy wires on a PC.", "host-sim"};
  app.set_version_flag("--version", SMASERVO_VERSION);
  // CLI11's own message, made printable because it quotes the command line.
  app.failure_message([](const CLI::App*, const CLI::Error& error) {
    return files::printable(error.what()) + "\nRun with --help for more information.\n";
  });
  app.require_subcommand(1);
  smaservo::plan::add_calibrate_plan_command(app);
  smaservo::can::add_can_command(app);
  smaservo::compare::add_compare_command(app);
  smaservo::convert::add_convert_command(app);
  smaservo::describe::add_describe_command(app);
  smaservo::evaluate::add_evaluate_command(app);
  smaservo::describe::add_explain_command(app);
  smaservo::figures::add_figures_command(app);
  smaservo::identify::add_identify_command(app);
  smaservo::page::add_page_command(app);
  smaservo::replay::add_replay_command(app);
  smaservo::replay::add_replay_device_command(app);
  smaservo::simulate::add_simulate_command(app);
  smaservo::tune::add_tune_command(app);
  smaservo::describe::add_wires_command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& result) {
    return result.get_exit_code();
  } catch (const CLI::ParseError& error) {
    if (argc > 1 && *argv[1] != '-' && app.get_subcommands().empty()) {
      files::complain("host-sim", fmt::format("{}: no such command", argv[1]));
    }
    return app.exit(error) == 0 ? 0 : wrong_command_line;
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    throw files::UserError(fmt::format("standard output: {}", std::strerror(errno)));
  }
  return 0;
}

}  // namespace smaservo
