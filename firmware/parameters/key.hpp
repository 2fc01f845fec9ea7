#pragma once
// The address of a value in CANopen and in a stored image.

#include <compare>
#include <cstdint>

namespace smaservo {

struct Key {
  std::uint16_t index;
  std::uint8_t sub;

  friend constexpr auto operator<=>(const Key&, const Key&) = default;
};

}  // namespace smaservo
