#include <array>
#include <fmt/format.h>
#include <memory>

#include "host-sim/canopen_reference.hpp"
#include "host-sim/commands.hpp"
#include "host-sim/fault_reference.hpp"
#include "host-sim/output_file.hpp"
#include "host-sim/parameter_reference.hpp"
#include "host-sim/settings_file.hpp"

namespace smaservo {
namespace {

struct Arguments {
  std::string topic;
  std::string wire{default_wire};
};

struct Topic {
  std::string_view name, meaning;
  std::string (*text)(const Arguments&);
};

constexpr auto topics = std::to_array<Topic>({
    {"dbc", "the frames of node 1 on CAN (firmware/canopen/smaservo.dbc)",
     [](const Arguments&) { return dbc_text(); }},
    {"eds", "electronic data sheet of the CANopen node (firmware/canopen/smaservo.eds)",
     [](const Arguments&) { return eds_text(); }},
    {"faults", "every fault of a device, in Markdown (firmware/FAULTS.md)",
     [](const Arguments&) { return fault_reference(); }},
    {"objects", "every object of the CANopen node, in Markdown (firmware/canopen/OBJECTS.md)",
     [](const Arguments&) { return object_reference(); }},
    {"parameters", "every parameter of a device, in Markdown (firmware/PARAMETERS.md)",
     [](const Arguments&) { return parameter_reference(); }},
    {"settings", "a settings file to start from, for the wire of --wire",
     [](const Arguments& a) { return settings_template(a.wire); }},
});

std::string list_of_topics() {
  std::string list;
  for (const Topic& topic : topics) {
    list += fmt::format("\n  {:<12}{}", topic.name, topic.meaning);
  }
  return list;
}

void describe(const Arguments& a) {
  for (const Topic& topic : topics) {
    if (topic.name == a.topic) {
      fmt::print("{}", topic.text(a));
      return;
    }
  }
  throw UserError(
      fmt::format("describe {}: no such topic; the topics are:{}", a.topic, list_of_topics()));
}

}  // namespace

void add_describe_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "describe", "Prints what the device knows of itself; made from the firmware's own tables.");
  auto a = std::make_shared<Arguments>();
  command->add_option("TOPIC", a->topic, "one of:" + list_of_topics())->required();
  command->add_option("--wire", a->wire, "preset or file that ends in .toml; " + a->wire);
  command->callback([a] { describe(*a); });
}

}  // namespace smaservo
