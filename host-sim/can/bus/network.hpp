#pragma once
// Finds the nodes on a bus, and describes frames in words.

#include <optional>
#include <string>
#include <vector>

#include "host-sim/can/bus/bus.hpp"

namespace smaservo::can {

struct FoundNode {
  unsigned node;
  /// From a heartbeat or a boot-up message; none if neither was received.
  std::optional<unsigned> nmt_state;
  bool answers = false;           ///< answers SDO requests; a stopped node does not
  std::uint32_t device_type = 0;  ///< value of 1000h
};

struct FoundNodes {
  std::vector<FoundNode> nodes;  ///< sorted by node-id
  bool without_id = false;       ///< a device without a node-id has answered the LSS request
};

/// Sends a request to every node-id, then listens for `listen_us`.
FoundNodes scan(Bus& bus, std::int64_t listen_us);

/// Describes a frame by its pre-defined identifier: "heartbeat of 5: operational".
std::string frame_text(const hal::CanFrame& frame);

}  // namespace smaservo::can
