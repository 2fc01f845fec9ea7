#pragma once
// Power by the model: to keep a wire as it is, and to bring it to a strain in a given time.

#include "firmware/prepared.hpp"
#include "model/wire/inverse.hpp"

namespace smaservo {

template <class S>
struct FeedForward {
  using Filter = KalmanObserver<S>;
  using Kinetics = typename Filter::Kinetics;

  /// The heat that the wire loses now, which equals the power that holds its temperature.
  static S loss_W(const Prepared<S>& p, const typename Filter::State& f) {
    const S above_K = Kinetics::drive(f.kinetics).temperature_K - f.ambient_K;
    return f.loss * p.observer.model.body.loss_W(above_K);
  }

  /// The power that brings in this heat within `time_s`, but in no less than three periods of the
  /// loop, which leaves room for the delay of a sample.
  static S power_W(const S& heat_J, const S& time_s, const S& dt_s) {
    const S shortest_s = S(3) * dt_s;
    return heat_J / (time_s < shortest_s ? shortest_s : time_s);
  }

  /// The heat that brings the wire to a strain, by the inverse of its model: strain -> phases ->
  /// temperature -> heat. `longer` is the strain that the wire has to gain. The heat is negative if
  /// the wire has to cool. Cost: about 200 instructions to heat, 450 to cool.
  static S heat_J(const Prepared<S>& p, const typename Filter::State& f, const S& longer) {
    const auto& model = p.observer.model;
    const S goal = Filter::whole_strain(p.observer, f) + longer;
    const bool heats = longer < S(0);
    const BranchPoint<S> to = heats ? Inverse<S>::heating(model, f.kinetics, f.stress_Pa, goal)
                                    : Inverse<S>::cooling(model, f.kinetics, f.stress_Pa, goal);
    const Phases<S> now = Kinetics::phases(f.kinetics);
    // E = m c (T' - T) + m ΔH_M (z_M - z_M') + m ΔH_R (z_R - z_R')
    const S heat_J =
        model.body.capacity_J_K * (to.temperature_K - Kinetics::drive(f.kinetics).temperature_K) +
        model.body.latent_m2a_J * (now.martensite - to.phases.martensite) +
        model.body.latent_r2a_J * (now.r_phase - to.phases.r_phase);
    return heats == (S(0) < heat_J) ? heat_J : S(0);
  }
};

}  // namespace smaservo
