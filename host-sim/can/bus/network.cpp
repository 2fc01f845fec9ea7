#include "host-sim/can/bus/network.hpp"

#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "firmware/canopen/node/object.hpp"
#include "firmware/safety/faults/table.hpp"
#include "firmware/text/canopen/abort_text.hpp"
#include "firmware/text/fault_reference.hpp"
#include "host-sim/can/remote.hpp"

namespace smaservo::can {
namespace {

constexpr unsigned max_nodes = 127;
constexpr std::uint32_t lss_request = 0x7E5;
constexpr std::uint32_t lss_answer = 0x7E4;
constexpr std::uint8_t identify_unconfigured = 0x4C;
constexpr std::uint8_t identified_unconfigured = 0x50;

/// The functions of CiA 301's pre-defined connection set, indexed by the upper four bits of the
/// identifier.
constexpr std::array<const char*, 16> functions{
    "NMT",    "EMCY",   "TIME",   "TPDO 1",     "RPDO 1",      "TPDO 2", "RPDO 2",    "TPDO 3",
    "RPDO 3", "TPDO 4", "RPDO 4", "SDO answer", "SDO request", "",       "heartbeat", "LSS"};

void note(std::array<FoundNode, max_nodes + 1>& nodes, FoundNodes& found,
          const hal::CanFrame& frame) {
  const unsigned node = frame.id & 0x7FU;
  const unsigned function = frame.id >> 7U;
  if (frame.extended || frame.remote) {
    return;
  }
  if (frame.id == lss_answer && frame.length == 8 && frame.data[0] == identified_unconfigured) {
    found.without_id = true;
  } else if (function == 14 && frame.length == 1) {
    nodes[node].nmt_state = frame.data[0] & 0x7FU;
  } else if (function == 11 && frame.length == 8) {
    nodes[node].answers = true;
    if (frame.data[0] == 0x43) {
      nodes[node].device_type =
          static_cast<std::uint32_t>(canopen::take_number(std::span(frame.data).subspan(4)));
    }
  }
}

std::string emergency_text(const hal::CanFrame& frame) {
  const auto code = static_cast<unsigned>(canopen::take_number(std::span(frame.data).first(2)));
  if (code == 0) {
    return "no error left";
  }
  const Fault fault = text::find_fault(fmt::format("{:04X}h", code));
  return fmt::format("{:04X}h{}", code,
                     fault == Fault::none ? "" : fmt::format(" {}", fault_name(fault)));
}

std::string nmt_text(const hal::CanFrame& frame) {
  const char* command = frame.data[0] == 1     ? "start"
                        : frame.data[0] == 2   ? "stop"
                        : frame.data[0] == 128 ? "pre-operational"
                        : frame.data[0] == 129 ? "reset node"
                        : frame.data[0] == 130 ? "reset communication"
                                               : "unknown command";
  return frame.data[1] == 0 ? fmt::format("NMT: {}, everybody", command)
                            : fmt::format("NMT: {}, node {}", command, frame.data[1]);
}

}  // namespace

FoundNodes scan(Bus& bus, std::int64_t listen_us) {
  FoundNodes found;
  std::array<FoundNode, max_nodes + 1> nodes{};
  hal::CanFrame frame;
  bus.send({.id = lss_request, .length = 8, .data = {identify_unconfigured}});
  for (unsigned node = 1; node <= max_nodes; ++node) {
    bus.send({.id = 0x600 + node, .length = 8, .data = {0x40, 0x00, 0x10, 0x00}});
    // Requests are sent a millisecond apart, so that no queue on the way has to hold all of them.
    const std::int64_t until_us = bus.now_us() + 1000;
    while (bus.receive(frame, until_us)) {
      note(nodes, found, frame);
    }
  }
  const std::int64_t until_us = bus.now_us() + listen_us;
  while (bus.receive(frame, until_us)) {
    note(nodes, found, frame);
  }
  for (unsigned node = 1; node <= max_nodes; ++node) {
    nodes[node].node = node;
    if (nodes[node].answers || nodes[node].nmt_state) {
      found.nodes.push_back(nodes[node]);
    }
  }
  return found;
}

std::string frame_text(const hal::CanFrame& frame) {
  const std::string data = fmt::format("{:02X}", fmt::join(frame.payload(), " "));
  if (frame.extended || frame.remote) {
    return fmt::format("{} {:X}h: not CANopen: {}", frame.remote ? "remote" : "extended", frame.id,
                       data);
  }
  const unsigned node = frame.id & 0x7FU;
  const unsigned function = frame.id >> 7U;
  if (frame.id == 0 && frame.length == 2) {
    return nmt_text(frame);
  }
  if (frame.id == 0x80) {
    return fmt::format("SYNC {}", data);
  }
  if (frame.id == lss_request) {
    return fmt::format("LSS request: {}", data);
  }
  if (frame.id == lss_answer) {
    return fmt::format("LSS answer: {}", data);
  }
  if (function == 1 && frame.length == 8) {
    return fmt::format("EMCY of {}: {}: {}", node, emergency_text(frame), data);
  }
  if (function == 14 && frame.length == 1) {
    return fmt::format("heartbeat of {}: {}", node, nmt_state_text(frame.data[0] & 0x7FU));
  }
  if ((function == 11 || function == 12) && frame.length == 8 && frame.data[0] == 0x80) {
    const auto code =
        static_cast<std::uint32_t>(canopen::take_number(std::span(frame.data).subspan(4)));
    return fmt::format("SDO abort of {}: {:08X}h {}", node, code, text::abort_text(code));
  }
  if (functions[function][0] == '\0') {
    return fmt::format("{:03X}h: {}", frame.id, data);
  }
  return fmt::format("{} of {}: {}", functions[function], node, data);
}

}  // namespace smaservo::can
