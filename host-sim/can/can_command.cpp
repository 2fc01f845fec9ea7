#include "host-sim/can/can_command.hpp"

#include <cstdio>
#include <fmt/format.h>

#include "host-sim/can/commands/session.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::can {
namespace {

constexpr const char* about_gains =
    "The gains strain.proportional_W, strain.integral_1_s and strain.derivative_s are 0 by\n"
    "default: the model alone drives the wire. `host-sim tune` proposes gains.";

}  // namespace

void print(const std::string& text) {
  files::print(text);
  std::fflush(stdout);
}

void say(const Common& common, const std::function<std::string()>& text) {
  if (common.quiet) {
    return;
  }
  try {
    files::print(text(), stderr);
  } catch (const files::UserError& error) {
    files::complain("host-sim", error.what());
  }
}

CLI::App* add(CLI::App& can, const char* name, const char* meaning,
              const std::function<void()>& run) {
  CLI::App* command = can.add_subcommand(name, meaning);
  command->fallthrough();
  command->callback(run);
  return command;
}

CLI::Validator seconds_of(double low, double high) {
  return {[=](std::string& text) {
            double value = 0;
            const bool fits =
                CLI::detail::lexical_cast(text, value) && low <= value && value <= high;
            return fits ? "" : fmt::format("{} is not within {} to {} s", text, low, high);
          },
          fmt::format("{} to {}", low, high)};
}

void add_plain(CLI::App& can, const std::shared_ptr<Common>& common, const char* name,
               const char* meaning, void (*run)(Remote&, const Common&)) {
  add(can, name, meaning, [common, run] {
    Session session(*common);
    run(session.remote(), *common);
  });
}

void add_can_command(CLI::App& app) {
  CLI::App* can =
      app.add_subcommand("can", "Talks to a servo over CAN: reads, tunes, moves, records.");
  auto common = std::make_shared<Common>();
  can->require_subcommand(1);
  can->add_option("--can", common->can, "can0, vcan0, ...; or udp, udp:GROUP[:PORT]")->required();
  can->add_option("--node", common->node, "node-id")
      ->capture_default_str()
      ->check(CLI::Range(1, 127));
  can->add_option("--key", common->key, "key of an access level (2003h)");
  can->add_option("--timeout", common->timeout_s, "longest wait for an answer, s")
      ->capture_default_str()
      ->check(seconds_of(0.01, 60));
  add_units_option(*can, common->units, "units of what is shown");
  can->add_flag("--quiet", common->quiet, "prints no line about the new state");
  add_network_commands(*can, common);
  add_object_commands(*can, common);
  add_watch_commands(*can, common);
  add_motion_commands(*can, common);
  // Not before: each command would have it.
  can->footer(about_gains);
  for (const char* const command : {"set", "try", "step"}) {
    can->get_subcommand(command)->footer(about_gains);
  }
}

}  // namespace smaservo::can
