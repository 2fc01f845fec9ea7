#pragma once
// Temperature of austenite by the rise of its resistance: a second opinion for the case that the
// observer is wrong about the air's temperature or the cooling. The power cannot show this error.
//
// While the wire is austenite, except for the ends that the clamps keep cold, only heat raises its
// resistance; the last martensite lowers it by disappearing. So since the lowest resistance R the
// wire has become warmer by at least ΔT = ΔR/R ρ/k, where k is the slope of the resistivity ρ over
// temperature; the effect of load and elastic strain is removed by the wire's file.

#include "firmware/safety/monitor/inputs.hpp"

namespace smaservo {

/// All zero: nothing has been seen.
template <class S>
struct HotResistance {
  S share;          ///< resistance as a share of austenite's under this load, filtered; 0: none yet
  S min;            ///< lowest share so far
  S min_at_K;       ///< estimated temperature at `min`
  S temperature_K;  ///< 0: not known
  bool heated;      ///< the power would keep the wire hot with half its cooling

  /// A greater rise is not due to heat: martensite has formed and the observer has not noticed.
  static constexpr S max_rise_K = S(80);

  /// Cost: about 40 operations, three divisions.
  void advance(const MonitorInputs<S>& seen) {
    const Estimate<S>& e = seen.estimate;
    if (!(e.martensite + e.r_phase < max_cold)) {
      *this = HotResistance{};
      return;
    }
    const bool first = !(S(0) < share);
    const S kept_W = net_W(seen);
    heated = !(kept_W < S(0));
    const S C = seen.prepared.observer.model.body.capacity_J_K;
    const S max = heated ? S(1000) : temperature_K + kept_W * seen.dt_s / C;
    if (!seen.precise()) {
      temperature_K = first || temperature_K < max ? temperature_K : max;
      return;
    }
    const S now = share_of_austenite(seen);
    share = first ? now : share + (now - share) * (seen.dt_s / (seen.dt_s + filter_s));
    const Phase<S>& a = seen.prepared.settings.wire.material.austenite;
    const S rise_K = (share - min) * a.resistivity_ohm_m / (min * a.resistivity_ohm_m_K);
    if (first || share < min || max_rise_K < rise_K) {
      min = share;
      min_at_K = e.temperature_K;
      temperature_K = min_at_K;
      return;
    }
    const S risen_K = min_at_K + rise_K;
    temperature_K = risen_K < max ? risen_K : max;
  }

  /// R ~ (ρ_0 + q σ)(1 + 2 ε), ε = σ/E
  static S share_of_austenite(const MonitorInputs<S>& seen) {
    const Phase<S>& a = seen.prepared.settings.wire.material.austenite;
    const S sigma = seen.filter.stress_Pa;
    const S strain = a.strain + sigma / a.modulus_Pa;
    return seen.measurement.resistance_ohm /
           ((a.resistivity_ohm_m + a.resistivity_ohm_m_Pa * sigma) * (S(1) + strain + strain));
  }

 private:
  static constexpr S max_cold = S(0.25);
  static constexpr S filter_s = S(0.02);
  static constexpr S min_loss = S(0.5);

  /// Net heat flow into the wire with half the cooling of its file. If it is negative the wire
  /// cools, whatever its resistance does.
  S net_W(const MonitorInputs<S>& seen) const {
    const S above_K = temperature_K - seen.filter.ambient_K;
    return seen.measurement.power_W - min_loss * seen.prepared.observer.model.body.loss_W(above_K);
  }
};

}  // namespace smaservo
