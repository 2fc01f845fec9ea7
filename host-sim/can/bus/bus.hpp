#pragma once
// A CAN bus as a client sees it: frames, and waiting for them.

#include <cstdint>
#include <string>

#include "hal/can_frame.hpp"

namespace smaservo::can {

class Bus {
 public:
  virtual ~Bus() = default;

  /// Throws UserError where the bus does not take it.
  virtual void send(const hal::CanFrame& frame) = 0;
  /// Waits for a frame at most until now_us() is there.
  virtual bool receive(hal::CanFrame& frame, std::int64_t until_us) = 0;
  virtual std::int64_t now_us() const = 0;
  virtual std::string name() const = 0;
};

}  // namespace smaservo::can
