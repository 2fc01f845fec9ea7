#pragma once
// Frames as python-can's udp_multicast interface writes them: a MessagePack map with the attributes
// of its class Message.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/can_frame.hpp"

namespace smaservo::hal {

/// `time_s` since 1970; receivers put their own in its place.
std::vector<std::uint8_t> to_datagram(const CanFrame& frame, double time_s);

/// Nothing where it is no frame of classic CAN: not such a map, an error frame, CAN FD, an
/// identifier or a length beyond the standard's.
std::optional<CanFrame> from_datagram(std::span<const std::uint8_t> datagram);

}  // namespace smaservo::hal
