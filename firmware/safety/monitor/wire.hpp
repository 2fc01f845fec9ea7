#pragma once
// Detects faults of the wire, its leads, its clamps and its load.

#include "firmware/safety/cooling/cooling_guard.hpp"
#include "firmware/safety/monitor/drive.hpp"
#include "firmware/safety/monitor/hot_resistance.hpp"
#include "firmware/safety/monitor/open_heat.hpp"

namespace smaservo {

template <class S>
struct WireMonitor {
  /// All zero: nothing has been seen.
  struct State {
    OpenHeat<S> heat;
    HotResistance<S> hot;
    CoolingGuard<S> cooling;
    S steady_ohm;          ///< low-pass filtered; 0: not known
    S unanswered_J;        ///< heat that the wire has been given without a response
    S observed_before_J;   ///< OpenHeat::observed_J in the last step
    S before_K;            ///< estimated temperature in the last step
    bool was_sure;         ///< the observer was sure in the last step
    S innovation_ohm;      ///< low-pass filtered
    S slips;               ///< number of slips seen; decays within 10 s
    bool slipping;         ///< the last step was part of a slip already
    bool contracted;       ///< the wire is in the contracted half of a cycle
    std::uint32_t cycles;  ///< full cycles; a main that stores the count puts it back here
  };

  /// Cost: about 150 operations, a division among them.
  static FaultSet detect(const MonitorInputs<S>& seen, State& s);

  /// Whether the resistance differs by more than trips.drift from what the model expects of a new
  /// wire. Both may be scaled by the same factor.
  static bool drifted(const Settings<S>& q, const S& measured_ohm, const S& expected_ohm) {
    return q.trips.drift * expected_ohm < magnitude(measured_ohm - expected_ohm);
  }

 private:
  static constexpr S beyond_K = S(2);
  static constexpr S jump = S(0.08);
  static constexpr S jump_s = S(0.003);
  /// How far the temperature is predicted: the trip must not be passed within the deglitch time and
  /// one step of a drive that is late.
  static constexpr S ahead_s = S(0.003);
  static constexpr S slip_forgotten_1_s = S(0.1);

  static void circuit(const MonitorInputs<S>& seen, FaultSet& now);
  static void temperature(const MonitorInputs<S>& seen, State& s, FaultSet& now);
  static bool jumped(const MonitorInputs<S>& seen, State& s);
  static void signature(const MonitorInputs<S>& seen, State& s, FaultSet& now);
  static void mechanics(const MonitorInputs<S>& seen, State& s, FaultSet& now);
  static void age(const MonitorInputs<S>& seen, State& s, FaultSet& now);
};

template <class S>
FaultSet WireMonitor<S>::detect(const MonitorInputs<S>& seen, State& s) {
  FaultSet now;
  if (seen.in.fresh) {
    circuit(seen, now);
    now.add(Fault::resistance_jump, jumped(seen, s));
  }
  if (seen.observing) {
    temperature(seen, s, now);
    signature(seen, s, now);
    mechanics(seen, s, now);
    age(seen, s, now);
  }
  return now;
}

template <class S>
void WireMonitor<S>::circuit(const MonitorInputs<S>& seen, FaultSet& now) {
  const MeasurementParams<S>& band = seen.prepared.measurement;
  const S R = seen.measurement.resistance_ohm;  // 0 if the current is too small
  const S low_A = seen.min_given_A();
  const bool measurable =
      band.min_current_A <= magnitude(seen.current_A) && seen.measurement.power_valid;
  const S nothing_ohm = S(0.02) * seen.prepared.cold_ohm;
  const bool no_voltage = measurable && R < nothing_ohm;
  now.add(Fault::sense_lead_open, no_voltage);
  now.add(Fault::wire_short, measurable && R < band.min_resistance_ohm && !no_voltage);
  const bool at_end = DriveMonitor<S>::voltage_at_end(seen);
  const bool no_current = S(0) < low_A && magnitude(seen.current_A) < S(0.2) * low_A;
  now.add(Fault::wire_open, no_current || (measurable && band.max_resistance_ohm < R && !at_end));
}

template <class S>
void WireMonitor<S>::temperature(const MonitorInputs<S>& seen, State& s, FaultSet& now) {
  const Settings<S>& q = seen.prepared.settings;
  const Estimate<S>& e = seen.estimate;
  s.heat.advance(seen);
  // Heat beyond what a draught could take away that has neither warmed nor transformed the wire.
  const bool sure = seen.sure();
  const ThermalBody<S>& body = seen.prepared.observer.model.body;
  const S warm_K = s.heat.finish_K < e.temperature_K ? e.temperature_K : s.heat.finish_K;
  const S max_loss_W = S(1.6) * body.loss_W(warm_K - seen.filter.ambient_K);
  const S unanswered_J = s.unanswered_J + (seen.measurement.power_W - max_loss_W) * seen.dt_s -
                         (s.heat.observed_J - s.observed_before_J);
  s.unanswered_J = S(0) < unanswered_J && sure ? unanswered_J : S(0);
  s.observed_before_J = s.heat.observed_J;
  now.add(Fault::no_response,
          S(20) * body.capacity_J_K + S(0.9) * body.latent_m2a_J < s.unanswered_J);
  const S coming_J = S(0) < s.heat.net_W ? s.heat.net_W * ahead_s : S(0);
  const auto passes = [&](const S& limit_K, const S& middle_K) {
    return body.capacity_J_K * (limit_K - q.limits.hot_spot_K - middle_K) < coming_J;
  };
  const S hottest_K =
      s.heat.temperature_K < e.temperature_K ? e.temperature_K : s.heat.temperature_K;
  now.add(Fault::over_temperature, passes(q.trips.temperature_K, hottest_K));
  now.add(Fault::heat_limit, seen.heated() && passes(q.limits.temperature_K, s.heat.temperature_K));
  // An observer that searches jumps from one hypothesis to another; that is no heating.
  const S warmer_K = sure && s.was_sure ? e.temperature_K - s.before_K : S(0);
  const S max_K = q.trips.heating_rate_K_s * seen.dt_s;
  now.add(Fault::heating_fast, S(0.7) * max_K < warmer_K);
  now.add(Fault::heating_rate, max_K < warmer_K);
  s.before_K = e.temperature_K;
  s.was_sure = sure;
}

/// Whether the resistance has changed faster than a transformation can change it, which under a
/// steady load needs the latent heat first.
template <class S>
bool WireMonitor<S>::jumped(const MonitorInputs<S>& seen, State& s) {
  const S R = seen.measurement.resistance_ohm;
  const S sigma = seen.filter.stress_Pa;
  const bool steady = seen.measurement.stress_valid &&
                      magnitude(seen.measurement.stress_Pa - sigma) < S(0.05) * sigma + S(5e6);
  if (!steady || !seen.observing || !seen.precise()) {
    s.steady_ohm = S(0);
    return false;
  }
  if (!(S(0) < s.steady_ohm)) {
    s.steady_ohm = R;
    return false;
  }
  const ThermalBody<S>& body = seen.prepared.observer.model.body;
  // The whole transformation changes the resistance by a quarter.
  const S by_heat = S(0.25) * seen.measurement.power_W * jump_s;
  const S max_J = jump * body.latent_m2a_J + by_heat;
  if (max_J * s.steady_ohm < magnitude(R - s.steady_ohm) * body.latent_m2a_J) {
    return true;
  }
  s.steady_ohm += (R - s.steady_ohm) * (seen.dt_s / (seen.dt_s + jump_s));
  return false;
}

/// The soft limit keeps the wire below limits.temperature_K by reducing the power; a wire above it
/// shows that this was not enough.
template <class S>
void WireMonitor<S>::signature(const MonitorInputs<S>& seen, State& s, FaultSet& now) {
  const Settings<S>& q = seen.prepared.settings;
  s.hot.advance(seen);
  const S hottest_K = s.hot.temperature_K + q.limits.hot_spot_K;
  now.add(Fault::overheat_onset, q.limits.temperature_K + beyond_K < hottest_K);
  s.cooling.advance(seen);
  now.add(Fault::cooling_weak, s.cooling.weak());
  now.add(Fault::cooling_lost, s.cooling.overheated());
  now.add(Fault::overheat_signature, s.hot.heated && q.trips.temperature_K < hottest_K);
}

template <class S>
void WireMonitor<S>::mechanics(const MonitorInputs<S>& seen, State& s, FaultSet& now) {
  const Settings<S>& q = seen.prepared.settings;
  const Measurement<S>& m = seen.measurement;
  const S strain = seen.estimate.strain;
  const bool slack = m.stress_valid && m.stress_Pa < q.trips.slack_Pa;
  now.add(Fault::load_lost, slack);
  now.add(Fault::over_stress, m.stress_valid && q.trips.stress_Pa < m.stress_Pa);
  now.add(Fault::over_strain,
          seen.sure() && (strain < q.trips.min_strain || q.trips.max_strain < strain));
  // When a wire slips its stress falls and its resistance rises, since more of it comes to lie
  // between the leads. When the load is taken away the wire shortens and its resistance falls. A
  // slack wire counts as load_lost only.
  const S jump_ohm = seen.filter.innovation_ohm - s.innovation_ohm;
  s.innovation_ohm += S(20) * seen.dt_s * jump_ohm;
  const bool slipping = m.stress_valid && m.resistance_valid && seen.sure() && !slack &&
                        m.stress_Pa < S(0.8) * seen.filter.stress_Pa &&
                        S(0.01) * seen.filter.model_ohm < jump_ohm;
  s.slips -= s.slips * slip_forgotten_1_s * seen.dt_s;
  if (slipping && !s.slipping) {
    s.slips += S(1);
  }
  s.slipping = slipping;
  now.add(Fault::slip_seen, S(0.5) < s.slips);
  now.add(Fault::clamp_slip, S(2.5) < s.slips);
}

template <class S>
void WireMonitor<S>::age(const MonitorInputs<S>& seen, State& s, FaultSet& now) {
  const Settings<S>& q = seen.prepared.settings;
  now.add(Fault::drift, seen.sure() && drifted(q, seen.filter.resistance, S(1)));
  const bool turned = s.contracted ? S(0.7) < seen.estimate.martensite + seen.estimate.r_phase
                                   : seen.estimate.martensite + seen.estimate.r_phase < S(0.3);
  if (turned && seen.sure()) {
    s.cycles = s.contracted ? s.cycles + 1 : s.cycles;
    s.contracted = !s.contracted;
  }
  now.add(Fault::cycles, q.trips.cycles <= s.cycles);
  now.add(Fault::duty, S(1.1) * q.limits.duty < seen.duty);
}

}  // namespace smaservo
