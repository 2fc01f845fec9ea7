#pragma once
// A CAN bus as a client uses it: send a frame, wait for a frame.

#include <cstdint>
#include <string>

#include "hal/can_frame.hpp"

namespace smaservo::can {

class Bus {
 public:
  virtual ~Bus() = default;

  /// Throws UserError when the bus does not accept the frame.
  virtual void send(const hal::CanFrame& frame) = 0;
  /// Waits for a frame until now_us() reaches `until_us`; false when none has come by then.
  virtual bool receive(hal::CanFrame& frame, std::int64_t until_us) = 0;
  virtual std::int64_t now_us() const = 0;
  virtual std::string name() const = 0;
  /// A transfer with a node begins or has ended: meanwhile nobody else may send it requests.
  virtual void transfer(unsigned /*node*/, bool /*goes_on*/) {}
};

}  // namespace smaservo::can
