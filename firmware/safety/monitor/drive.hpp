#pragma once
// Detects faults of the supply and the output stage.

#include "firmware/safety/monitor/inputs.hpp"
#include "firmware/safety/monitor/zero_current.hpp"

namespace smaservo {

template <class S>
struct DriveMonitor {
  /// The voltage reading is at the end of its scale.
  static bool voltage_at_end(const MonitorInputs<S>& seen) {
    return full * seen.prepared.settings.measurement.voltage_full_scale_V <=
           magnitude(seen.in.sample.voltage_V);
  }

  /// Returns the faults whose conditions are present now. Cost: about 60 operations, no division.
  static FaultSet detect(const MonitorInputs<S>& seen, const ZeroCurrent<S>& zero);

 private:
  static constexpr S full = S(0.998);  ///< share of a scale that counts as its end, because a
                                       ///< converter's last code is below the full scale
  static constexpr S warm_K = S(10);

  static void supply(const MonitorInputs<S>& seen, FaultSet& now);
  static void current(const MonitorInputs<S>& seen, FaultSet& now);
  static void voltage(const MonitorInputs<S>& seen, FaultSet& now);
};

template <class S>
FaultSet DriveMonitor<S>::detect(const MonitorInputs<S>& seen, const ZeroCurrent<S>& zero) {
  FaultSet now;
  now.add(Fault::driver_fault, seen.in.driver_fault);
  if (seen.in.fresh) {
    supply(seen, now);
    current(seen, now);
    voltage(seen, now);
  }
  now.add(Fault::current_offset, zero.known() && !zero.in_band(seen.prepared));
  return now;
}

/// A reading without a sensor is NaN, and every comparison with it is false.
template <class S>
void DriveMonitor<S>::supply(const MonitorInputs<S>& seen, FaultSet& now) {
  const Settings<S>& q = seen.prepared.settings;
  now.add(Fault::supply_low, seen.in.supply_V < q.drive.min_supply_V);
  now.add(Fault::supply_high, q.drive.max_supply_V < seen.in.supply_V);
  now.add(Fault::driver_warm, q.trips.driver_K - warm_K < seen.in.driver_K);
  now.add(Fault::driver_hot, q.trips.driver_K < seen.in.driver_K);
}

template <class S>
void DriveMonitor<S>::current(const MonitorInputs<S>& seen, FaultSet& now) {
  const Settings<S>& q = seen.prepared.settings;
  const S I = magnitude(seen.current_A);
  const S noise_A = S(6) * q.measurement.current_noise_A;
  const S doubt_A = q.trips.current_offset_A + noise_A;
  now.add(Fault::over_current, q.trips.current_A < I);
  now.add(Fault::current_saturated,
          full * q.measurement.current_full_scale_A <= magnitude(seen.in.sample.current_A));
  // A dead current sensor reads zero; then the voltage shows that a current flows.
  const S floating_V = S(2) * q.limits.min_current_A * seen.prepared.cold_ohm;
  now.add(Fault::current_while_off,
          seen.off() && (doubt_A + doubt_A < I || floating_V < magnitude(seen.voltage_V)));
  // Too little current from a converter that has no more voltage is no fault of the current loop;
  // wire_open and the measured resistance cover that case.
  const bool all_it_has =
      S(0.9) * seen.in.supply_V < seen.voltage_V || seen.last.limited_by(LimitReason::supply);
  const S low_A = seen.min_given_A();
  const bool too_much = S(1.15) * seen.max_given_A() + doubt_A < I;
  const bool too_little = I < S(0.85) * low_A - doubt_A && S(0.2) * low_A <= I && !all_it_has;
  now.add(Fault::current_control, !seen.off() && (too_much || too_little));
}

template <class S>
void DriveMonitor<S>::voltage(const MonitorInputs<S>& seen, FaultSet& now) {
  const Settings<S>& q = seen.prepared.settings;
  // Without current a saturated voltage is an open wire: wire_open.
  const bool flows = seen.prepared.measurement.min_current_A <= magnitude(seen.current_A);
  now.add(Fault::voltage_saturated, flows && voltage_at_end(seen));
  const S slack_V = S(0.5);
  const bool above_supply = S(1.05) * seen.in.supply_V + slack_V < seen.voltage_V;
  // The wire gets far less than the chopper's mean voltage; 30 % are allowed for leads and crimps.
  const bool lost = q.drive.kind == DriveKind::voltage && seen.measurement.resistance_ohm > S(0) &&
                    seen.voltage_V < S(0.7) * seen.last.drive_voltage_V - slack_V &&
                    !(S(1.1) * seen.given_before_A < seen.last.drive_current_A);
  now.add(Fault::kelvin_mismatch, above_supply || lost);
}

}  // namespace smaservo
