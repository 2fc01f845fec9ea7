#pragma once
// Detects active faults from the inputs of one step. It only detects: failsafe.hpp and
// supervisor.hpp decide what follows.
//
// Thresholds come from the settings, except a few that follow from physics or arithmetic and are
// written where they are used. A healthy wire never triggers a fault
// (tests/firmware/safety/monitor_test.cpp).

#include "firmware/safety/deglitch.hpp"
#include "firmware/safety/monitor/drive.hpp"
#include "firmware/safety/monitor/estimate.hpp"
#include "firmware/safety/monitor/machine.hpp"
#include "firmware/safety/monitor/stall.hpp"
#include "firmware/safety/monitor/wire.hpp"

namespace smaservo {

template <class S>
struct Monitor {
  /// All zero: nothing has been seen yet.
  struct State {
    ZeroCurrent<S> zero;
    typename WireMonitor<S>::State wire;
    typename EstimateMonitor<S>::State estimate;
    typename MachineMonitor<S>::State machine;
    Deglitch<S> deglitch;
  };

  /// Returns the conditions that have lasted for their deglitch time.
  static FaultSet step(const MonitorInputs<S>& seen, State& s) {
    if (seen.stalled) [[unlikely]] {
      return s.deglitch.step(after_stall(seen, s), seen.dt_s);
    }
    if (seen.in.fresh && !(seen.off_s < ZeroCurrent<S>::settling_s) && seen.off()) {
      s.zero.take(seen.prepared, seen.in.sample);
    }
    const FaultSet now =
        DriveMonitor<S>::detect(seen, s.zero) | WireMonitor<S>::detect(seen, s.wire) |
        EstimateMonitor<S>::detect(seen, s.estimate) | MachineMonitor<S>::detect(seen, s.machine);
    return s.deglitch.step(now, seen.dt_s);
  }

 private:
  [[gnu::noinline]] static FaultSet after_stall(const MonitorInputs<S>& seen, State& s);
};

/// The sample after a stall is not the response to the last command, because the guard or the
/// one-shot may have ended the current at any time. So no fault is concluded from it, not even an
/// open wire. The heat content is continued with seen.measurement; it is never below the observer's
/// value for the same power.
template <class S>
FaultSet Monitor<S>::after_stall(const MonitorInputs<S>& seen, State& s) {
  const StalledTime<S> time(seen.prepared, seen.dt_s);
  if (seen.observing) {
    OpenHeat<S>& heat = s.wire.heat;
    const ThermalBody<S>& body = seen.prepared.observer.model.body;
    const S smooth_s = S(0.125) * body.capacity_J_K / body.loss_W_K;
    MonitorInputs<S> part = seen;
    part.dt_s = smooth_s < S(0.25) ? smooth_s : S(0.25);
    for (S left_s = time.all_s; S(0) < left_s; left_s -= part.dt_s) {
      part.dt_s = left_s < part.dt_s ? left_s : part.dt_s;
      heat.advance(part);
    }
    heat.heat_J = heat.heat_J < heat.observed_J ? heat.observed_J : heat.heat_J;
  }
  // Readings from before the stall must not be compared with readings after it.
  s.wire.steady_ohm = S(0);
  s.wire.unanswered_J = S(0);
  s.wire.was_sure = false;
  s.wire.cooling.miss();
  s.machine.sampled = false;
  s.machine.misses = S(0);
  FaultSet now = seen.in.external;
  now.add(Fault::loop_stalled, true);
  now.add(Fault::emergency_stop, seen.in.emergency_stop);
  now.add(Fault::driver_fault, seen.in.driver_fault);
  return now;
}

}  // namespace smaservo
