#pragma once
// A CAN bus as a client uses it: sends a frame, or waits for one.

#include <cstdint>
#include <string>

#include "hal/can_frame.hpp"

namespace smaservo::can {

class Bus {
 public:
  virtual ~Bus() = default;

  /// Throws UserError if the bus does not accept the frame.
  virtual void send(const hal::CanFrame& frame) = 0;
  /// Waits for a frame until now_us() reaches `until_us`; false if none has come by then.
  virtual bool receive(hal::CanFrame& frame, std::int64_t until_us) = 0;
  virtual std::int64_t now_us() const = 0;
  virtual std::string name() const = 0;
  /// Called when a transfer with a node begins or ends; between these calls no other client may
  /// send requests to the node.
  virtual void transfer(unsigned /*node*/, bool /*goes_on*/) {}
};

}  // namespace smaservo::can
