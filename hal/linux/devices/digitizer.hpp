#pragma once
// Raw codes of one instant. Their meaning is not known here: a board calibrates what a converter
// reads.

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/board.hpp"

namespace smaservo::hal {

inline constexpr std::size_t max_channels = 16;

struct RawFrame {
  std::int64_t time_ns;
  std::uint32_t sequence;  ///< counts samples
  std::array<std::int64_t, max_channels> codes;
};

/// A converter that samples all its channels at the same time.
class Digitizer {
 public:
  Digitizer() = default;
  virtual ~Digitizer() = default;
  Digitizer(const Digitizer&) = delete;
  Digitizer& operator=(const Digitizer&) = delete;

  /// Reads the newest frame; waits for it at most for a part of a period. False: none has come, or
  /// it was damaged, and `raw` is meaningless. Allocates nothing.
  virtual bool read(RawFrame& raw) = 0;
};

}  // namespace smaservo::hal
