#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fmt/format.h>

#include "host-sim/commands.hpp"
#include "model/files/error.hpp"

namespace {

constexpr int wrong_command_line = 2;

int run(int argc, char** argv) {
  CLI::App app{"Replays, simulates and describes shape-memory-alloy wires on a PC.", "host-sim"};
  app.set_version_flag("--version", SMASERVO_VERSION);
  app.require_subcommand(1);
  smaservo::plan::add_calibrate_plan_command(app);
  smaservo::can::add_can_command(app);
  smaservo::compare::add_compare_command(app);
  smaservo::describe::add_describe_command(app);
  smaservo::evaluate::add_evaluate_command(app);
  smaservo::describe::add_explain_command(app);
  smaservo::figures::add_figures_command(app);
  smaservo::identify::add_identify_command(app);
  smaservo::replay::add_replay_command(app);
  smaservo::simulate::add_simulate_command(app);
  smaservo::tune::add_tune_command(app);
  smaservo::describe::add_wires_command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& result) {
    return result.get_exit_code();
  } catch (const CLI::ParseError& error) {
    if (argc > 1 && *argv[1] != '-' && app.get_subcommands().empty()) {
      fmt::print(stderr, "host-sim: {}: no such command\n", argv[1]);
    }
    return app.exit(error) == 0 ? 0 : wrong_command_line;
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    throw smaservo::files::UserError(fmt::format("standard output: {}", std::strerror(errno)));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fputs("host-sim: ", stderr);
    std::fputs(error.what(), stderr);
    std::fputs("\n", stderr);
  }
  return 1;
}
