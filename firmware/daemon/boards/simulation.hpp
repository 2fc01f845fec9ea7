#pragma once
// A simulated wire as the daemon's board, and its program as the daemon's command source.

#include <string>

#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "firmware/daemon/loop/command_source.hpp"
#include "hal/sim/board.hpp"

namespace smaservo::daemon {

/// Time is that of the simulation: each frame advances it by one period, independent of the clock.
/// No more frames come after the scenario's end.
class Simulation : public CommandSource {
 public:
  static constexpr bool in_monotonic_time = false;

  /// Throws ConfigError for a pair of wires and for events that restart the device, since a daemon
  /// supports neither.
  explicit Simulation(const bench::ClosedLoopScenario& scenario);

  // The members that hal::Board requires.
  hal::ReadStatus read(hal::Frame& frame);
  void drive(const hal::DriveCommand& command) { board_.drive(command); }
  void safe_off() { board_.safe_off(); }
  void kick() { board_.kick(); }
  std::int64_t now_ns() const { return board_.now_ns(); }

  // The member that CommandSource requires.
  Heard<double> listen(double time_s) override;

  hal::SimTruth truth() const { return board_.truth(); }

 private:
  hal::SimBoard board_;
  bench::CommandProgram program_;
  bench::SimEvents events_;
  bool has_program_, began_ = false;
  std::int64_t period_ns_, end_ns_;
};

static_assert(hal::Board<Simulation>);

/// Moves the wire up and down between two lengths, 2 s each, for ever; for a first test.
class Demonstration : public CommandSource {
 public:
  explicit Demonstration(const Settings<double>& settings);
  Heard<double> listen(double time_s) override;

 private:
  double short_, long_;
};

}  // namespace smaservo::daemon
