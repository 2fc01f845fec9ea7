#pragma once
// Who is on the bus, and what is said there.

#include <optional>
#include <string>
#include <vector>

#include "host-sim/can/bus/bus.hpp"

namespace smaservo::can {

struct FoundNode {
  unsigned node;
  std::optional<unsigned> nmt_state;  ///< where a heartbeat or a boot-up was heard
  bool answers = false;               ///< to SDO; a stopped node does not
  std::uint32_t device_type = 0;      ///< 1000h
};

struct FoundNodes {
  std::vector<FoundNode> nodes;  ///< in the order of their numbers
  bool without_id = false;       ///< somebody has no node-id, and answers to LSS
};

/// Asks every node and listens for so long.
FoundNodes scan(Bus& bus, std::int64_t listen_us);

/// What a frame says, by its pre-defined identifier: "heartbeat of 5: operational".
std::string frame_text(const hal::CanFrame& frame);

}  // namespace smaservo::can
