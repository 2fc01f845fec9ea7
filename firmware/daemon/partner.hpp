#pragma once
// Who tells the device what to do: a bus, a program of commands, a recording.

#include "firmware/command.hpp"

namespace smaservo {

/// What a turn is told.
struct Heard {
  Command<double> command;
  FaultSet external;
  bool late = false;  ///< as recorded or simulated; the loop knows by itself when it really is
};

/// Both calls are the loop's: they neither wait nor allocate.
class Partner {
 public:
  Partner() = default;
  virtual ~Partner() = default;
  Partner(const Partner&) = delete;
  Partner& operator=(const Partner&) = delete;

  virtual Heard listen(double time_s) = 0;
  virtual void tell(const Output<double>& /*output*/) {}
};

/// Nobody: the device stays off.
class NoPartner : public Partner {
 public:
  Heard listen(double /*time_s*/) override { return {{.fresh = true}, {}}; }
};

}  // namespace smaservo
