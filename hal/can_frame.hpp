#pragma once
// A frame of classic CAN, as all ports receive and send it.

#include <array>
#include <cstdint>
#include <span>

namespace smaservo::hal {

struct CanFrame {
  std::uint32_t id = 0;                ///< 11 bits, or 29 with `extended`
  bool extended = false;               ///< 29-bit identifier; CANopen uses none
  bool remote = false;                 ///< requests a frame instead of carrying data
  std::uint8_t length = 0;             ///< number of data bytes, 0 to 8
  std::array<std::uint8_t, 8> data{};  ///< zero beyond `length`

  std::span<const std::uint8_t> payload() const { return std::span(data).first(length); }
  bool operator==(const CanFrame&) const = default;
};

}  // namespace smaservo::hal
