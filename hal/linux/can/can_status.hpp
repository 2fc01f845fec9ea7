#pragma once
// What a CAN port knows of its bus.

#include <cstdint>
#include <stdexcept>

namespace smaservo::hal {

/// A port that can not be opened: names it and says why.
class CanError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A port that can not be, as its name is none.
class CanNameError : public CanError {
 public:
  using CanError::CanError;
};

enum class CanState : unsigned char {
  active,
  passive,  ///< so many errors that the controller has withdrawn to listening and careful sending
  bus_off,  ///< the controller does not take part; with restart-ms 0 for ever
  down,     ///< the interface has been set down
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
  std::uint64_t dropped_full = 0;  ///< not sent: the queue was full
  std::uint64_t dropped_down = 0;  ///< not sent: down, gone or unreachable
  std::uint64_t lost = 0;          ///< came, but the receive queue was full
  std::uint64_t malformed = 0;     ///< came, but is no frame of classic CAN
  std::uint64_t error_frames = 0;
  std::uint64_t bus_offs = 0;
  std::uint64_t downs = 0;    ///< the interface went down or disappeared
  std::uint64_t reopens = 0;  ///< it had disappeared and came back
};

}  // namespace smaservo::hal
