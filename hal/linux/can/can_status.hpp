#pragma once
// State and statistics of a CAN port.

#include <cstdint>

#include "model/files/error.hpp"

namespace smaservo::hal {

/// A port cannot be opened; the text names it and says why.
class CanError : public files::Error {
 public:
  using Error::Error;
};

/// The name of a port is malformed.
class CanNameError : public CanError {
 public:
  using CanError::CanError;
};

enum class CanState : unsigned char {
  active,
  passive,  ///< after many errors: the controller receives, but sends with restrictions
  bus_off,  ///< the controller is off the bus; permanently if restart-ms is 0
  down,     ///< the interface was set down
  gone,     ///< the interface has disappeared
};

constexpr const char* name(CanState state) {
  switch (state) {
    case CanState::active:
      return "active";
    case CanState::passive:
      return "error-passive";
    case CanState::bus_off:
      return "bus-off";
    case CanState::down:
      return "down";
    case CanState::gone:
      return "gone";
  }
  return "";
}

/// Counts since the port was opened.
struct CanStatistics {
  std::uint64_t received = 0;
  std::uint64_t sent = 0;
  std::uint64_t dropped_full = 0;  ///< frames not sent because the queue was full
  /// Frames not sent because the port was down, gone or unreachable.
  std::uint64_t dropped_down = 0;
  std::uint64_t lost = 0;       ///< frames received, but lost because the receive queue was full
  std::uint64_t malformed = 0;  ///< datagrams received that are not frames of classic CAN
  std::uint64_t error_frames = 0;
  std::uint64_t bus_offs = 0;
  std::uint64_t downs = 0;    ///< times that the interface went down or disappeared
  std::uint64_t reopens = 0;  ///< times that the interface came back after it had disappeared
};

}  // namespace smaservo::hal
