#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fmt/format.h>

#include "host-sim/commands.hpp"
#include "host-sim/output_file.hpp"

int main(int argc, char** argv) {
  CLI::App app{"Replays, simulates and describes shape-memory-alloy wires on a PC.", "host-sim"};
  app.set_version_flag("--version", SMASERVO_VERSION);
  app.require_subcommand(1);
  smaservo::add_replay_command(app);
  smaservo::add_simulate_command(app);
  smaservo::add_wires_command(app);
  try {
    app.parse(argc, argv);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
      throw smaservo::UserError(fmt::format("standard output: {}", std::strerror(errno)));
    }
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "host-sim: {}\n", error.what());
    return 1;
  }
  return 0;
}
