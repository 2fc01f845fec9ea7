#pragma once
// Detects that the estimate, or the loop that uses it, is not to be trusted.

#include "firmware/safety/monitor/inputs.hpp"
#include "model/scalar/scalar.hpp"

namespace smaservo {

/// Modes whose controlled variable comes from the observer.
constexpr bool needs_estimate(Mode mode) {
  return mode == Mode::strain || mode == Mode::position || mode == Mode::temperature;
}

template <class S>
struct EstimateMonitor {
  /// All zero: nothing has been seen.
  struct State {
    S innovation_ohm;  ///< low-pass filtered
    S away_s;          ///< time for which the strain has been away from its reference
  };

  /// Cost: about 50 operations, no division.
  static FaultSet detect(const MonitorInputs<S>& seen, State& s);

 private:
  static constexpr S filter_1_s = S(10);
  /// Square of the number of standard deviations that the filtered innovation must stay below.
  static constexpr S far = S(36);

  static bool diverged(const MonitorInputs<S>& seen, State& s);
  static bool away(const MonitorInputs<S>& seen, State& s);
  static void surroundings(const MonitorInputs<S>& seen, FaultSet& now);
};

template <class S>
FaultSet EstimateMonitor<S>::detect(const MonitorInputs<S>& seen, State& s) {
  FaultSet now;
  if (!seen.observing) {
    return now;
  }
  const Estimate<S>& e = seen.estimate;
  now.add(Fault::estimate_invalid,
          !isfinite(e.strain + e.strain_sd + e.temperature_K + e.martensite + e.r_phase));
  // Without heat the observer cannot become sure, and that is no fault: a cold wire may wait for
  // its first command.
  const bool heated =
      S(2) * seen.prepared.settings.limits.min_current_A < seen.last.drive_current_A;
  now.add(Fault::estimate_unsure, seen.last.state == DeviceState::running && heated &&
                                      needs_estimate(seen.command.mode) &&
                                      e.health != Health::good);
  now.add(Fault::model_divergence, diverged(seen, s));
  now.add(Fault::following_error, away(seen, s));
  surroundings(seen, now);
  return now;
}

/// The filter expects the variance s² of the innovation ν in each step. If ν is white noise, its
/// low-pass filtered value has the variance s² dt/2τ, with the time constant τ.
template <class S>
bool EstimateMonitor<S>::diverged(const MonitorInputs<S>& seen, State& s) {
  const auto& f = seen.filter;
  if (!seen.measurement.resistance_valid || seen.estimate.health == Health::searching) {
    s.innovation_ohm = S(0);
    return false;
  }
  const S share = filter_1_s * seen.dt_s;
  s.innovation_ohm += share * (f.innovation_ohm - s.innovation_ohm);
  return far * f.innovation_variance * share < S(2) * s.innovation_ohm * s.innovation_ohm;
}

template <class S>
bool EstimateMonitor<S>::away(const MonitorInputs<S>& seen, State& s) {
  const Settings<S>& q = seen.prepared.settings;
  const bool position = seen.last.mode == Mode::position;
  if (seen.last.state != DeviceState::running || (seen.last.mode != Mode::strain && !position)) {
    s.away_s = S(0);
    return false;
  }
  const S length_m = q.wire.geometry.length_m;
  const S reference_m = position ? q.axis.zero_strain * length_m - seen.last.reference
                                 : seen.last.reference * length_m;
  const S error_m = magnitude(seen.estimate.strain * length_m - reference_m);
  s.away_s = q.trips.following_error * length_m < error_m ? s.away_s + seen.dt_s : S(0);
  return q.trips.following_s <= s.away_s;
}

template <class S>
void EstimateMonitor<S>::surroundings(const MonitorInputs<S>& seen, FaultSet& now) {
  const Settings<S>& q = seen.prepared.settings;
  const KalmanTuning<S>& t = seen.prepared.observer.tuning;
  const auto& f = seen.filter;
  if (seen.sure()) {
    const S edge = S(0.98);
    now.add(Fault::power_balance,
            edge * t.loss_range < f.loss || t.loss_range * f.loss * edge < S(1) ||
                edge * t.ambient_range_K < magnitude(f.ambient_K - f.start_ambient_K));
  }
  const S air_K = isfinite(seen.in.ambient_K) ? seen.in.ambient_K : f.ambient_K;
  now.add(Fault::ambient_range, air_K < q.trips.min_ambient_K || q.trips.max_ambient_K < air_K);
  if (seen.heated()) {
    return;
  }
  const S strain = seen.estimate.strain;
  const bool outside =
      (seen.measurement.stress_valid && q.limits.stress_Pa < seen.measurement.stress_Pa) ||
      strain < q.trips.min_strain || q.trips.max_strain < strain ||
      q.limits.temperature_K < seen.estimate.temperature_K + q.limits.hot_spot_K;
  now.add(Fault::started_outside, outside);
}

}  // namespace smaservo
