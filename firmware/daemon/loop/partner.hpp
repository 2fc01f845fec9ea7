#pragma once
// Who tells the device what to do: a bus, a program of commands, a recording.

#include "firmware/text/turn.hpp"

namespace smaservo {

/// Both calls are the loop's: they neither wait nor allocate.
class Partner {
 public:
  Partner() = default;
  virtual ~Partner() = default;
  Partner(const Partner&) = delete;
  Partner& operator=(const Partner&) = delete;

  /// Late is a turn as recorded or simulated; the loop knows by itself when it really is.
  virtual Heard<double> listen(double time_s) = 0;
  /// What came of it.
  virtual void tell(const Turn& /*turn*/, double /*dt_s*/) {}
};

/// Nobody: the device stays off.
class NoPartner : public Partner {
 public:
  Heard<double> listen(double /*time_s*/) override { return {{.fresh = true}, {}}; }
};

}  // namespace smaservo
