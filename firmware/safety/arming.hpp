#pragma once
// The look at the wire before it is heated: a sense current, the resistance. The observer may still
// be unsure where the wire is: one heating tells, and that can not be had before.

#include "firmware/safety/monitor/estimate.hpp"
#include "firmware/safety/monitor/wire.hpp"

namespace smaservo {

/// An empty one has not begun.
template <class S>
struct ArmingCheck {
  S expected_ohm;  ///< by the model, of a wire that has not aged
  S sum_ohm, samples;
  bool cold;  ///< the wire has the air's temperature

  static constexpr S settling_s = S(0.01);
  static constexpr S min_s = S(0.05);
  static constexpr S max_s = S(0.1);  ///< what has not been found by then is missing

  /// With the last sample before the sense current flows.
  static ArmingCheck begin(const MonitorInputs<S>& seen) {
    return {seen.filter.model_ohm / seen.filter.resistance, S(0), S(0), seen.cold()};
  }

  void take(const MonitorInputs<S>& seen, const S& since_s) {
    if (!(since_s < settling_s) && seen.measurement.resistance_valid) {
      sum_ohm += seen.measurement.resistance_ohm;
      samples += S(1);
    }
  }

  /// What speaks against heating this wire; none: it may be. A wire that may still be warm is only
  /// known to be within the band of the measurement, between a short and an open one.
  FaultSet findings(const MonitorInputs<S>& seen) const {
    const Settings<S>& q = seen.prepared.settings;
    const S cold_ohm = seen.prepared.cold_ohm * samples;
    const bool out = cold && (sum_ohm < q.trips.resistance_low * cold_ohm ||
                              q.trips.resistance_high * cold_ohm < sum_ohm);
    FaultSet found;
    found.add(Fault::cold_resistance, samples < S(1) || out);
    found.add(Fault::drift, cold && S(0) < samples &&
                                WireMonitor<S>::drifted(q, sum_ohm, expected_ohm * samples));
    return found;
  }
};

}  // namespace smaservo
