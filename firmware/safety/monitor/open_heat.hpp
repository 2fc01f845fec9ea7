#pragma once
// Temperature of the wire by the heat that it was given, without its resistance: a second opinion
// for the case that a wrong reading deceives the observer.

#include "firmware/safety/monitor/inputs.hpp"

namespace smaservo {

/// All zero: a cold wire.
template <class S>
struct OpenHeat {
  S heat_J;         ///< heat content; 0 is martensite at the air's temperature
  S temperature_K;  ///< temperature at this heat content, on the heating branch
  S finish_K;       ///< end of the transformation into austenite, under the present stress
  S net_W;          ///< net heat flow into the wire in the last step
  S observed_J;     ///< heat content by the observer's estimate, from the same zero

  /// Rates at which heat_J approaches observed_J, so that errors of the open-loop heat, above all
  /// in inner loops, do not add up. A deceived observer takes the wire for colder than it is, so
  /// heat_J falls towards it more slowly than it rises.
  static constexpr S warms_1_s = S(0.5);
  static constexpr S cools_1_s = S(0.1);
  /// A deceived observer may also estimate a draught or cold air that would keep the wire cold. So
  /// its estimate counts only up to this cooling, relative to the wire file's, and down to air that
  /// is this much colder than at the start.
  static constexpr S max_loss = S(1);
  static constexpr S colder_K = S(2);

  /// Cost: about 50 operations, a division among them.
  void advance(const MonitorInputs<S>& seen) {
    const auto& f = seen.filter;
    const ThermalBody<S>& body = seen.prepared.observer.model.body;
    const Surface<S>& m2a = seen.prepared.observer.model.kinetics.m2a;
    const S coldest_K = f.start_ambient_K - colder_K;
    const S believed_K = f.ambient_K < coldest_K ? coldest_K : f.ambient_K;
    const S air_K = believed_K < seen.in.ambient_K ? seen.in.ambient_K : believed_K;
    const auto at = [&](const S(&c)[3]) {
      return c[0] + f.stress_Pa * (c[1] + f.stress_Pa * c[2]);
    };
    const S start_K = at(m2a.start_K);
    finish_K = at(m2a.finish_K);
    const S C = body.capacity_J_K;
    const S L = body.latent_m2a_J;
    const S start_J = C * (start_K - air_K);
    const S finish_J = C * (finish_K - air_K) + L;
    // Between start and finish the latent heat is spread evenly.
    temperature_K = heat_J < start_J    ? air_K + heat_J / C
                    : finish_J < heat_J ? finish_K + (heat_J - finish_J) / C
                                        : start_K + (heat_J - start_J) * (finish_K - start_K) /
                                                        (finish_J - start_J);
    // Without a measurement the given current is taken, the most that can have flowed.
    const S given_A = seen.last.drive_current_A;
    const S power_W = seen.in.fresh && seen.measurement.power_valid
                          ? seen.measurement.power_W
                          : given_A * given_A * seen.prepared.cold_ohm;
    const S loss = f.loss < max_loss ? f.loss : max_loss;
    net_W = power_W - loss * body.loss_W(temperature_K - air_K);
    const Estimate<S>& e = seen.estimate;
    const S austenite = S(1) - e.martensite - e.r_phase;
    observed_J =
        C * (e.temperature_K - air_K) + L * austenite + (L - body.latent_r2a_J) * e.r_phase;
    const S missing_J = observed_J - heat_J;
    heat_J += (net_W + (missing_J < S(0) ? cools_1_s : warms_1_s) * missing_J) * seen.dt_s;
  }
};

}  // namespace smaservo
