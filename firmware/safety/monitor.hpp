#pragma once
// Detects which faults are active, from what is known in one step. It only detects: failsafe.hpp
// and supervisor.hpp decide what follows.
//
// Thresholds come from the settings, except a few that follow from physics or arithmetic and stand
// where they are used. A healthy wire never triggers a fault
// (tests/firmware/safety/monitor_test.cpp).

#include "firmware/safety/deglitch.hpp"
#include "firmware/safety/monitor/drive.hpp"
#include "firmware/safety/monitor/estimate.hpp"
#include "firmware/safety/monitor/machine.hpp"
#include "firmware/safety/monitor/wire.hpp"

namespace smaservo {

template <class S>
struct Monitor {
  /// All zero: nothing has been seen.
  struct State {
    ZeroCurrent<S> zero;
    typename WireMonitor<S>::State wire;
    typename EstimateMonitor<S>::State estimate;
    typename MachineMonitor<S>::State machine;
    Deglitch<S> deglitch;
  };

  /// Conditions that have lasted for their deglitch time.
  static FaultSet step(const MonitorInputs<S>& seen, State& s) {
    if (seen.in.fresh && !(seen.off_s < ZeroCurrent<S>::settling_s) && seen.off()) {
      s.zero.take(seen.prepared, seen.in.sample);
    }
    const FaultSet now =
        DriveMonitor<S>::detect(seen, s.zero) | WireMonitor<S>::detect(seen, s.wire) |
        EstimateMonitor<S>::detect(seen, s.estimate) | MachineMonitor<S>::detect(seen, s.machine);
    return s.deglitch.step(now, seen.dt_s);
  }
};

}  // namespace smaservo
