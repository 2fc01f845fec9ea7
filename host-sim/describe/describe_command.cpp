#include "host-sim/describe/describe_command.hpp"

#include <array>
#include <fmt/format.h>
#include <memory>

#include "firmware/text/canopen/canopen_reference.hpp"
#include "firmware/text/canopen/parameter_reference.hpp"
#include "firmware/text/fault_reference.hpp"
#include "firmware/text/settings_file.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/wire/wire_header.hpp"

namespace smaservo::describe {
namespace {

struct DescribeArguments {
  std::string topic;
  std::string wire{files::default_wire};
  std::string as{"toml"};
  bool real_defaults = false;
};

struct Topic {
  std::string_view name, meaning;
  std::string (*text)(const DescribeArguments&);
};

constexpr auto topics = std::to_array<Topic>({
    {"dbc", "the frames of node 1 on CAN (firmware/reference/smaservo.dbc)",
     [](const DescribeArguments&) { return text::dbc_text(); }},
    {"eds", "electronic data sheet of the CANopen node (firmware/reference/smaservo.eds)",
     [](const DescribeArguments& a) {
       return text::eds_text(a.real_defaults ? text::RealDefaults::decimal
                                             : text::RealDefaults::none);
     }},
    {"faults", "every fault of a device, in Markdown (firmware/reference/FAULTS.md)",
     [](const DescribeArguments&) { return text::fault_reference(); }},
    {"objects", "objects of the CANopen node other than parameters, in Markdown (OBJECTS.md)",
     [](const DescribeArguments&) { return text::object_reference(); }},
    {"parameters", "every parameter of a device, in Markdown (firmware/reference/PARAMETERS.md)",
     [](const DescribeArguments&) { return text::parameter_reference(); }},
    {"settings", "a settings file to start from, for the wire of --wire",
     [](const DescribeArguments& a) { return text::settings_template(a.wire); }},
    {"wire", "the wire of --wire with all its numbers: a wire file, or with --as header C++",
     [](const DescribeArguments& a) {
       const files::WireDescription wire = files::load_wire(a.wire);
       return a.as == "header" ? files::to_header(wire) : files::to_toml(wire);
     }},
});

std::string list_of_topics() {
  std::string list;
  for (const Topic& topic : topics) {
    list += fmt::format("\n  {:<12}{}", topic.name, topic.meaning);
  }
  return list;
}

void describe(const DescribeArguments& a) {
  if (a.as != "toml" && a.topic != "wire") {
    throw files::UserError(fmt::format(
        "describe {} --as {}: --as is for the topic wire alone; leave it out", a.topic, a.as));
  }
  for (const Topic& topic : topics) {
    if (topic.name == a.topic) {
      files::print(topic.text(a));
      return;
    }
  }
  std::string names;
  for (const Topic& topic : topics) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", topic.name);
  }
  throw files::UserError(
      fmt::format("describe {}: no such topic; the topics are {}", a.topic, names));
}

}  // namespace

void add_describe_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "describe", "Prints the device's parameters, objects or faults, or settings to start from.");
  auto a = std::make_shared<DescribeArguments>();
  command->add_option("TOPIC", a->topic, "one of:" + list_of_topics())->required();
  command->add_option("--wire", a->wire, "preset or file that ends in .toml; " + a->wire);
  command->add_option("--as", a->as, "of wire: toml, or header for a program that reads no files")
      ->check(CLI::IsMember({"toml", "header"}));
  command->add_flag("--real-defaults", a->real_defaults,
                    "of eds: with decimal defaults of REAL32 objects, for gocanopen, which needs "
                    "them; Lely and ros2_canopen refuse them");
  command->callback([a] { describe(*a); });
}

}  // namespace smaservo::describe
