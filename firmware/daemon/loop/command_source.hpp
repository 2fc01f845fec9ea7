#pragma once
// Who tells the device what to do: a bus, a program of commands, a recording.

#include "firmware/cycle.hpp"

namespace smaservo::daemon {

/// The loop calls both functions, so they neither wait nor allocate.
class CommandSource {
 public:
  CommandSource() = default;
  virtual ~CommandSource() = default;
  CommandSource(const CommandSource&) = delete;
  CommandSource& operator=(const CommandSource&) = delete;

  /// Heard::late is set for a cycle that was late in a recording or a simulation; the loop itself
  /// notices when it really is late.
  virtual Heard<double> listen(double time_s) = 0;
  /// Gets the inputs and outputs of the cycle that has just run.
  virtual void tell(const Cycle& /*cycle*/, double /*dt_s*/) {}
};

/// A source without commands: the device stays off.
class NoCommandSource : public CommandSource {
 public:
  Heard<double> listen(double /*time_s*/) override { return {{.fresh = true}, {}}; }
};

}  // namespace smaservo::daemon
