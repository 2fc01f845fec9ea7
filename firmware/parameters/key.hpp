#pragma once
// The address of a value in CANopen and in a stored image, and who may write there.

#include <compare>
#include <cstdint>
#include <string_view>

namespace smaservo {

struct Key {
  std::uint16_t index;
  std::uint8_t sub;

  friend constexpr auto operator<=>(const Key&, const Key&) = default;
};

/// Who may write a value, by what it can do to the heat.
enum class Level : std::uint8_t {
  operate,  ///< drives within the limits
  tune,     ///< changes how the limits are approached
  set_up,   ///< changes the limits themselves, the wire, the sensors, and when heat ends
};
inline constexpr std::string_view level_names[] = {"operate", "tune", "set up"};

}  // namespace smaservo
