#pragma once
// A wire of one temperature: power and load in, strain and resistance out.

#include "model/kinetics.hpp"
#include "model/wire/heat.hpp"
#include "model/wire/material.hpp"
#include "model/wire/wire.hpp"

namespace smaservo {

/// What acts on the wire during one step.
template <class S>
struct PlantInput {
  S power_W;
  S stress_Pa;
  S ambient_K;
};

/// A wire of one temperature, with cold ends. The state is a value; a step changes it in place.
template <Kinetics K>
struct Plant {
  using S = typename K::Scalar;

  /// What a wire is; plant_params() makes it.
  struct Params {
    typename K::Params kinetics;
    Material<S> material;
    ThermalBody<S> body;
    ColdEnds<S> ends;
    S length_per_area_1_m;
  };

  /// The wire's history, and what a step leaves to the next one.
  struct State {
    typename K::State kinetics;
    S heat_J;  ///< heat error of the last step's linearisation, carried into the next step
  };

  /// A wire that was cooled to this temperature at this stress from far above, and rests there.
  static State rest(const Params& p, const Drive<S>& u) { return {K::rest(p.kinetics, u), S(0)}; }

  /// Of the wire's middle.
  static S temperature_K(const State& s) { return K::drive(s.kinetics).temperature_K; }
  /// Of the wire's middle.
  static Phases<S> phases(const State& s) { return K::phases(s.kinetics); }
  /// Elongation of the whole wire.
  static S strain(const Params& p, const State& s) {
    return smaservo::strain(p.material, p.ends.average(phases(s)), K::drive(s.kinetics).stress_Pa);
  }
  /// Resistance of the whole wire, whose ends are at the ambient temperature.
  static S resistance_ohm(const Params& p, const State& s, const S& ambient_K) {
    return resistance_ohm(p, phases(s), K::drive(s.kinetics), ambient_K);
  }
  /// The resistance of a wire whose middle is at the drive `u` and has these phases.
  static S resistance_ohm(const Params& p, const Phases<S>& phases, const Drive<S>& u,
                          const S& ambient_K) {
    const Drive<S> average{p.ends.average_K(u.temperature_K, ambient_K), u.stress_Pa};
    const Phases<S> z = p.ends.average(phases);
    return smaservo::resistance_ohm(resistivity(p.material, z, average).value,
                                    p.length_per_area_1_m,
                                    smaservo::strain(p.material, z, u.stress_Pa));
  }

  /// dt_s > 0, meant for 10 us to 20 ms. Latent heat enters through the effective heat capacity,
  /// implicitly, so no step is stiff; the error of the linearisation is carried into the next step,
  /// so no energy is lost. A step that would move the temperature by more than 1 K is divided into
  /// substeps.
  static void advance(const Params& p, State& s, const PlantInput<S>& in, const S& dt_s) {
    const int parts = substeps(p, s, in, dt_s);
    const S part_s = dt_s / S(parts);
    for (int i = 0; i < parts; ++i) {
      advance_part(p, s, in, part_s);
    }
  }

 private:
  static constexpr int max_substeps = 64;

  static int substeps(const Params& p, const State& s, const PlantInput<S>& in, const S& dt_s) {
    const S heat_J =
        s.heat_J + (in.power_W - p.body.loss_W(temperature_K(s) - in.ambient_K)) * dt_s;
    const S magnitude_J = heat_J < S(0) ? -heat_J : heat_J;
    int parts = 1;
    while (parts < max_substeps && p.body.capacity_J_K * S(parts) < magnitude_J) {
      parts *= 2;
    }
    return parts;
  }

  static void advance_part(const Params& p, State& s, const PlantInput<S>& in, const S& dt_s) {
    const S T = temperature_K(s);
    const S above = T - in.ambient_K;
    const S heat_J = s.heat_J + (in.power_W - p.body.loss_W(above)) * dt_s;
    const Heading heading = S(0) < heat_J ? Heading::heating : Heading::cooling;
    const PhaseRates<S> rates = K::rates(p.kinetics, s.kinetics, heading);
    const Phases<S> before = phases(s);
    // (m c_eff + h S dt) dT = (P - Q(T)) dt
    const S loss_J_K = p.body.loss_slope_W_K(above) * dt_s;
    const S dT = heat_J / (p.body.effective_capacity_J_K(rates) + loss_J_K);
    K::advance(p.kinetics, s.kinetics, {T + dT, in.stress_Pa});
    const Phases<S> after = phases(s);
    s.heat_J = heat_J - (p.body.capacity_J_K + loss_J_K) * dT +
               p.body.latent_m2a_J * (after.martensite - before.martensite) +
               p.body.latent_r2a_J * (after.r_phase - before.r_phase);
  }
};

/// The parameters of a plant with the wire's own model.
template <class S>
typename Plant<ThreePhase<S>>::Params plant_params(const Wire<S>& wire) {
  return {wire.kinetics, wire.material, thermal_body(wire.geometry, wire.heat),
          cold_ends(wire.geometry, wire.heat, wire.kinetics), wire.length_per_area_1_m()};
}

/// Resistance of the wire as it lies on the table: at rest at 25 °C without load.
template <class S>
S cold_resistance_ohm(const Wire<S>& wire) {
  using Model = Plant<ThreePhase<S>>;
  const auto params = plant_params(wire);
  return Model::resistance_ohm(params, Model::rest(params, {S(room_K), S(0)}), S(room_K));
}

}  // namespace smaservo
