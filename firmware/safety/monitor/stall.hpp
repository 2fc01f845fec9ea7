#pragma once
// Assumptions on a stall: a time in which the loop stood still. Nothing has observed the output, so
// the worst case is assumed, that the last command persisted all the time.

#include <cmath>

#include "firmware/prepared.hpp"
#include "firmware/timing.hpp"

namespace smaservo {

/// The time of a stall, divided into steps of the model. After about twenty of its time constants
/// the wire has the temperature that its power keeps, so the time after that is ignored.
template <class S>
struct StalledTime {
  S all_s;    ///< length of the stall that counts
  S part_s;   ///< length of one step of the observer, at most a third of a time constant
  int parts;  ///< number of these steps

  /// Most steps of the filter for one stall; bounds the cost on a microcontroller.
  static constexpr int max_parts = 64;
  static constexpr S shortest_part_s = S(5e-3);

  [[gnu::noinline]] StalledTime(const Prepared<S>& p, const S& dt_s) {
    using std::ceil;
    const ThermalBody<S>& body = p.observer.model.body;
    // The same time as in MonitorInputs::cold(): time constants, and time for the latent heat.
    const S longest_s = (S(10) * body.capacity_J_K + S(0.2) * body.latent_m2a_J) / body.loss_W_K;
    all_s = dt_s < longest_s ? dt_s : longest_s;
    const S wanted = ceil(all_s / shortest_part_s - S(0.5));
    parts = wanted < S(1) ? 1 : wanted < S(max_parts) ? static_cast<int>(wanted) : max_parts;
    part_s = all_s / S(parts);
  }
};

/// The greatest power that a command of this current and voltage can have put into the wire.
template <class S>
S persisting_power_W(const Prepared<S>& p, const S& current_A, const S& voltage_V) {
  const S by_current_W = current_A * current_A * p.cold_ohm;
  if (p.settings.drive.kind != DriveKind::voltage) {
    return by_current_W;
  }
  // The resistance falls by a quarter while the wire contracts.
  const S by_voltage_W = voltage_V * voltage_V / (S(0.75) * p.cold_ohm);
  return by_current_W < by_voltage_W ? by_voltage_W : by_current_W;
}

}  // namespace smaservo
