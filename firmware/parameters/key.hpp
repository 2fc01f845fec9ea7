#pragma once
// The address of a value in CANopen and in a stored image, and the level needed to write it.

#include <compare>
#include <cstdint>
#include <string_view>

namespace smaservo {

struct Key {
  std::uint16_t index;
  std::uint8_t sub;

  friend constexpr auto operator<=>(const Key&, const Key&) = default;
};

/// The level needed to write a value, by its possible effect on the heat.
enum class Level : std::uint8_t {
  operate,  ///< drives within the limits
  tune,     ///< changes how the limits are approached
  set_up,   ///< changes the limits themselves, the wire, the sensors, and the conditions that end
            ///< the heat
};
inline constexpr std::string_view level_names[] = {"operate", "tune", "set up"};

}  // namespace smaservo
