#include <cstdio>
#include <exception>
#include <fmt/format.h>

#include "host-sim/commands.hpp"

int main(int argc, char** argv) {
  CLI::App app{"Replays, simulates and describes shape-memory-alloy wires on a PC.", "host-sim"};
  app.set_version_flag("--version", SMASERVO_VERSION);
  app.require_subcommand(1);
  smaservo::add_replay_command(app);
  smaservo::add_simulate_command(app);
  smaservo::add_wires_command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "host-sim: {}\n", error.what());
    return 1;
  }
  return 0;
}
