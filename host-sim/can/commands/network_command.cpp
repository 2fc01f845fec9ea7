#include <fmt/format.h>
#include <memory>

#include "firmware/safety/faults/table.hpp"
#include "firmware/text/fault_reference.hpp"
#include "host-sim/can/bus/network.hpp"
#include "host-sim/can/commands/session.hpp"
#include "host-sim/can/status.hpp"
#include "model/files/error.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::can {
namespace {

void scan(const Common& common, double listen_s) {
  can::PortBus bus(common.can);
  const can::FoundNodes found = can::scan(bus, static_cast<std::int64_t>(listen_s * 1e6));
  files::TextTable table({{"", "{}"}, {""}, {""}});
  for (const can::FoundNode& node : found.nodes) {
    const can::SdoClient client(bus, node.node);
    Remote remote(client);
    table.add({node.node, node.nmt_state ? can::nmt_state_text(*node.nmt_state) : "",
               node.answers ? remote.text("1008") : "does not answer to SDO"});
  }
  if (found.without_id) {
    table.add({"?", "without a node-id", "answers to LSS"});
  }
  print(table.text());
  if (found.nodes.empty() && !found.without_id) {
    throw files::UserError(fmt::format("{}: no node answers", bus.name()));
  }
}

void listen(const Common& common, double for_s) {
  can::PortBus bus(common.can);
  const std::int64_t start_us = bus.now_us();
  const std::int64_t until_us = start_us + static_cast<std::int64_t>(for_s * 1e6);
  hal::CanFrame frame;
  while (bus.receive(frame, until_us)) {
    print(fmt::format("{:10.4f}  {}\n", static_cast<double>(bus.now_us() - start_us) * 1e-6,
                      can::frame_text(frame)));
  }
}

void explain(const std::shared_ptr<Common>& common, const std::string& name) {
  Fault fault = text::find_fault(name);
  if (!name.empty() && fault == Fault::none) {
    throw files::UserError(fmt::format("{}: no such fault; `host-sim explain` lists them", name));
  }
  if (name.empty()) {
    Session session(*common);
    fault = can::first_cause(session.remote());
    if (fault == Fault::none) {
      print(fmt::format("node {} has no fault\n", common->node));
      return;
    }
  }
  print(text::explain_fault(fault));
}

}  // namespace

void add_network_commands(CLI::App& can, const std::shared_ptr<Common>& common) {
  auto seconds = std::make_shared<double>(0.3);
  add(can, "scan", "Lists the nodes of the bus.", [=] { scan(*common, *seconds); })
      ->add_option("--listen", *seconds, "time to wait for heartbeats, s")
      ->capture_default_str()
      ->check(seconds_of(0, 3600));
  auto listen_s = std::make_shared<double>(1e6);
  add(can, "listen", "Prints every frame on the bus in words.", [=] { listen(*common, *listen_s); })
      ->add_option("--for", *listen_s, "duration, s; default: 1000000 s, 11 days")
      ->check(seconds_of(0, 1e6));
  add_plain(can, common, "info", "Prints identity, versions, states, loop and bus of a node.",
            [](Remote& remote, const Common& c) { print(can::info_text(remote, c.units)); });
  add_plain(can, common, "faults",
            "Prints faults, their first cause, and what blocks or limits the output.",
            [](Remote& remote, const Common&) { print(can::faults_text(remote)); });
  add_plain(can, common, "changes",
            "Prints the last accepted and refused writes, the newest at the end.",
            [](Remote& remote, const Common&) { print(can::changes_text(remote)); });
  auto name = std::make_shared<std::string>();
  add(can, "explain", "Says what a fault means and what to check.", [=] {
    explain(common, *name);
  })->add_option("FAULT", *name, "name or code; default: the node's first cause");
}

}  // namespace smaservo::can
