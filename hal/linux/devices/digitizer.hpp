#pragma once
// Raw codes of one instant. Their meaning is not known here: a board calibrates the codes of its
// converter.

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/board.hpp"

namespace smaservo::hal {

inline constexpr std::size_t max_channels = 16;

struct RawFrame {
  std::int64_t time_ns;
  std::uint32_t sequence;  ///< number of the sample
  std::array<std::int64_t, max_channels> codes;
};

/// A converter that samples all its channels at the same time.
class Digitizer {
 public:
  Digitizer() = default;
  virtual ~Digitizer() = default;
  Digitizer(const Digitizer&) = delete;
  Digitizer& operator=(const Digitizer&) = delete;

  /// Reads the newest frame; waits for it at most a part of a period. False if there is no new
  /// frame or it was damaged; `raw` is then meaningless. Allocates nothing.
  virtual bool read(RawFrame& raw) = 0;
};

}  // namespace smaservo::hal
