#include <memory>

#include "host-sim/can/plain_node.hpp"
#include "host-sim/commands.hpp"

namespace smaservo {
namespace {

struct Arguments {
  std::string eds, can;
  unsigned node_id = 1;
  double duration_s = 0;
};

}  // namespace

void add_node_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "node",
      "A CANopen node that serves any data sheet with plain storage: for tests of masters, and of "
      "this stack by other test suites. Runs until it is interrupted.");
  auto a = std::make_shared<Arguments>();
  command->add_option("--eds", a->eds, "data sheet, .eds")->required();
  command->add_option("--can", a->can, "can0, any CAN interface; udp, udp:GROUP, udp:GROUP:PORT")
      ->required();
  command->add_option("--node-id", a->node_id, "1 to 127; 1")->check(CLI::Range(1, 127));
  command->add_option("--duration", a->duration_s, "in s; for ever")->check(CLI::Range(0.0, 1e9));
  command->callback([a] {
    run_plain_node(a->eds, a->can, static_cast<std::uint8_t>(a->node_id), a->duration_s);
  });
}

}  // namespace smaservo
