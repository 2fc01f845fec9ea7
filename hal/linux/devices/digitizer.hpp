#pragma once
// Raw codes of one instant, and what they mean: the two are apart, so that a converter is read in
// one place and calibrated in another.

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/board.hpp"

namespace smaservo::hal {

inline constexpr std::size_t max_channels = 16;

struct RawFrame {
  std::int64_t time_ns;
  std::uint32_t sequence;  ///< of the samples, counted by whoever can
  std::array<std::int64_t, max_channels> codes;
};

/// A converter that samples its channels at once.
class Digitizer {
 public:
  Digitizer() = default;
  virtual ~Digitizer() = default;
  Digitizer(const Digitizer&) = delete;
  Digitizer& operator=(const Digitizer&) = delete;

  /// The newest frame, waited for at most for a part of a period. False: none has come, or it was
  /// damaged; `raw` means nothing then. No allocation.
  virtual bool read(RawFrame& raw) = 0;
};

}  // namespace smaservo::hal
