#pragma once
// The model alone, driven by the measured power and stress: the estimate of an observer without
// correction. A reference for comparison, and the part of the Kalman filter that predicts.

#include "model/wire/plant.hpp"
#include "observer/estimate.hpp"

namespace smaservo {

/// The observer without a correction. Its estimate has no standard deviation.
template <class S>
struct OpenLoopObserver {
  using Scalar = S;
  using Model = Plant<ThreePhase<S>>;

  /// The wire.
  struct Params {
    typename Model::Params model;
  };

  /// What changes; trivially copyable.
  struct State {
    typename Model::State plant;
    S ambient_K;
    S stress_Pa;
  };

  /// The wire rests at the ambient temperature under the measured stress, cooled from far above.
  static State start(const Params& p, const Measurement<S>& m, const S& ambient_K) {
    return {Model::rest(p.model, {ambient_K, m.stress_Pa}), ambient_K, m.stress_Pa};
  }

  /// The power and stress of the measurement act for dt_s, 0 to 5 ms. A stress that is not valid
  /// leaves the last one in force. Cost: one step of the plant.
  static void advance(const Params& p, State& s, const Measurement<S>& m, const S& dt_s) {
    if (m.stress_valid) {
      s.stress_Pa = m.stress_Pa;
    }
    Model::advance(p.model, s.plant, {m.power_W, s.stress_Pa, s.ambient_K}, dt_s);
  }

  /// The present strain, temperature and phases. Its strain_sd is 0: nothing tells how far it is
  /// off.
  static Estimate<S> estimate(const Params& p, const State& s) {
    const Phases<S> z = p.model.ends.average(Model::phases(s.plant));
    return {Model::strain(p.model, s.plant),
            S(0),
            Model::temperature_K(s.plant),
            z.martensite,
            z.r_phase,
            Model::resistance_ohm(p.model, s.plant, s.ambient_K),
            Health::good};
  }
};

}  // namespace smaservo
