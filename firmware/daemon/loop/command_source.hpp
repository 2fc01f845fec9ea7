#pragma once
// Who tells the device what to do: a bus, a program of commands, a recording.

#include "firmware/text/cycle.hpp"

namespace smaservo::daemon {

/// Both calls are the loop's: they neither wait nor allocate.
class CommandSource {
 public:
  CommandSource() = default;
  virtual ~CommandSource() = default;
  CommandSource(const CommandSource&) = delete;
  CommandSource& operator=(const CommandSource&) = delete;

  /// Late is a cycle as recorded or simulated; the loop knows by itself when it really is.
  virtual Heard<double> listen(double time_s) = 0;
  /// What came of it.
  virtual void tell(const text::Cycle& /*cycle*/, double /*dt_s*/) {}
};

/// Nobody: the device stays off.
class NoCommandSource : public CommandSource {
 public:
  Heard<double> listen(double /*time_s*/) override { return {{.fresh = true}, {}}; }
};

}  // namespace smaservo::daemon
