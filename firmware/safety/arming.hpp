#pragma once
// The check of the wire before it is heated: its resistance is measured with a sense current. The
// observer may still be unsure of the wire's state, which only heating can clarify.

#include "firmware/safety/monitor/estimate.hpp"
#include "firmware/safety/monitor/wire.hpp"

namespace smaservo {

/// All zero: the check has not begun.
template <class S>
struct ArmingCheck {
  S expected_ohm;  ///< resistance by the model, for a wire that has not aged
  S sum_ohm, samples;
  bool cold;  ///< the wire is known to have the air's temperature

  static constexpr S settling_s = S(0.01);
  static constexpr S min_s = S(0.05);
  static constexpr S max_s = S(0.1);  ///< a check that has not passed by this time has failed

  /// To be called with the last sample before the sense current flows.
  static ArmingCheck begin(const MonitorInputs<S>& seen) {
    return {seen.filter.model_ohm / seen.filter.resistance, S(0), S(0), seen.cold()};
  }

  void take(const MonitorInputs<S>& seen, const S& since_s) {
    if (!(since_s < settling_s) && seen.measurement.resistance_valid) {
      sum_ohm += seen.measurement.resistance_ohm;
      samples += S(1);
    }
  }

  /// The reasons not to heat this wire; empty if it may be heated. If the wire may still be warm,
  /// its resistance is not compared with that of a cold one: it only has to be measurable, between
  /// a short circuit and an open wire.
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
