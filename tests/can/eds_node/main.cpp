// A CANopen node that serves any data sheet with plain storage: for tests of masters, and of this
// stack by other test suites.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "tests/can/eds_node/plain_node.hpp"

namespace {

constexpr int wrong_command_line = 2;

int run(int argc, char** argv) {
  std::string eds;
  std::string can;
  unsigned node_id = 1;
  double duration_s = 0;
  CLI::App app{"Serves a data sheet on CAN until it is interrupted.", "eds_node"};
  app.add_option("--eds", eds, "data sheet, .eds")->required();
  app.add_option("--can", can, "can0, any CAN interface; udp, udp:GROUP, udp:GROUP:PORT")
      ->required();
  app.add_option("--node-id", node_id, "1 to 127; 1")->check(CLI::Range(1, 127));
  app.add_option("--duration", duration_s, "in s; for ever")->check(CLI::Range(0.0, 1e9));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : wrong_command_line;
  }
  smaservo::run_plain_node(eds, can, static_cast<std::uint8_t>(node_id), duration_s);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fputs("eds_node: ", stderr);
    std::fputs(error.what(), stderr);
    std::fputs("\n", stderr);
  }
  return 1;
}
