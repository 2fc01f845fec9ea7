#pragma once
// The records in the pipes between the emulated board and the program that simulates its wire.
// Little-endian; one Drive and one Readings per period, CAN frames as they come.

#include <array>
#include <cstdint>
#include <type_traits>

namespace smaservo::cortex_m::link {

/// Sent before each period; the answer is the readings at its end.
struct Drive {
  float current_A, voltage_V;
  std::int32_t lease_us;  ///< time from now for which the command is valid
  std::uint32_t kicked;   ///< 1: the one-shot has been triggered
};

enum Flag : std::uint32_t {
  fresh = 1U << 0U,
  emergency_stop = 1U << 1U,
  driver_fault = 1U << 2U,
};

struct Readings {
  std::uint32_t sequence, flags;
  float current_A, voltage_V, load_N, supply_V, ambient_K, driver_K;
};

/// From the board: a frame to send, or the question whether one has been received. To the board:
/// the answer to the question.
struct Can {
  std::uint32_t frames;  ///< 0 or 1
  std::uint32_t id;
  std::uint8_t length;
  std::array<std::uint8_t, 7> padding;
  std::array<std::uint8_t, 8> data;
};

static_assert(sizeof(Drive) == 16 && sizeof(Readings) == 32 && sizeof(Can) == 24);
static_assert(std::is_trivially_copyable_v<Can>);

}  // namespace smaservo::cortex_m::link
