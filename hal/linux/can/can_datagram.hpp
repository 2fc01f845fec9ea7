#pragma once
// Frames as python-can's udp_multicast interface writes them: a MessagePack map with the attributes
// of its class Message.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/can_frame.hpp"

namespace smaservo::hal {

/// `time_s` counts from 1970; receivers replace it by the time of reception.
std::vector<std::uint8_t> to_datagram(const CanFrame& frame, double time_s);

/// nullopt if the datagram is not a frame of classic CAN: not a map of this kind, an error frame,
/// CAN FD, or an identifier or length beyond the standard's.
std::optional<CanFrame> from_datagram(std::span<const std::uint8_t> datagram);

}  // namespace smaservo::hal
