#pragma once
// One wire: geometry, the maker's limits and the parameters of all model blocks.

#include <cmath>
#include <numbers>

#include "model/wire/heat.hpp"
#include "model/wire/material.hpp"
#include "model/wire/three_phase/three_phase.hpp"

namespace smaservo {

/// The wire's dimensions.
template <class S>
struct Geometry {
  S length_m;
  S diameter_m;

  /// The cross-section.
  constexpr S area_m2() const { return S(std::numbers::pi / 4) * diameter_m * diameter_m; }
  /// The wire's surface without its ends.
  constexpr S surface_m2() const { return S(std::numbers::pi) * diameter_m * length_m; }
};

/// What the heat balance needs of the alloy and of the air.
template <class S>
struct HeatParams {
  S density_kg_m3;
  S specific_heat_J_kgK;
  S latent_m2a_J_kg;
  S latent_r2a_J_kg;
  S convection_W_m2K;         ///< h at the ambient temperature
  S convection_W_m2K2;        ///< its slope over the temperature above ambient
  S clamp_conductivity_W_mK;  ///< conductivity of the wire towards clamps at ambient temperature;
                              ///< 0: none
};

/// The limits that the maker states, and the range in which the parameters hold.
template <class S>
struct Limits {
  S current_A;
  S stress_Pa;
  S temperature_K;
};

/// How far the model is from the wire: root mean square of the errors that a calibration could not
/// explain. The observers derive from `strain` how far to trust their model; `resistance` is for
/// information only.
template <class S>
struct Accuracy {
  S strain;      ///< error of the model's strain, driven by power and load alone
  S resistance;  ///< relative error of the resistance that the model gives to a strain
};

/// All parameters of a wire, as a wire file has them.
template <class S>
struct Wire {
  Geometry<S> geometry;
  Limits<S> limits;
  S nominal_stroke;  ///< strain to which errors are related, 0.04 by convention
  ThreePhaseParams<S> kinetics;
  Material<S> material;
  HeatParams<S> heat;
  Accuracy<S> accuracy;

  /// Length over cross-section: resistance over resistivity without strain.
  constexpr S length_per_area_1_m() const { return geometry.length_m / geometry.area_m2(); }
  /// The stress that a load makes.
  constexpr S stress_Pa(S load_N) const { return load_N / geometry.area_m2(); }
};

/// How far the cold of a clamp reaches into the wire: λ = sqrt(k d/(4 h)).
template <class S>
S clamp_reach_m(const Geometry<S>& geometry, const HeatParams<S>& heat) {
  using std::sqrt;
  return sqrt(heat.clamp_conductivity_W_mK * geometry.diameter_m / (S(4) * heat.convection_W_m2K));
}

/// The ends that a clamp keeps cold. They neither contract nor lose resistance; a model of one
/// temperature that ignores them makes the wire up to 3 % of its stroke too short.
template <class S>
struct ColdEnds {
  S share;           ///< share of the wire's length
  Phases<S> phases;  ///< fractions in the ends

  /// The phases of the whole wire, from those of its middle.
  constexpr Phases<S> average(const Phases<S>& middle) const {
    return {middle.martensite + share * (phases.martensite - middle.martensite),
            middle.r_phase + share * (phases.r_phase - middle.r_phase)};
  }
  /// The mean temperature of the whole wire, from that of its middle; the clamps have the ambient
  /// one.
  constexpr S average_K(const S& middle_K, const S& ambient_K) const {
    return middle_K - share * (middle_K - ambient_K);
  }
};

/// The temperature rises over the reach λ as 1 - exp(-x/λ); the position of the transformation
/// front in it depends on how hot the middle is. A constant of 0.87 λ at each end fits the
/// distributed plant best.
template <class S>
ColdEnds<S> cold_ends(const Geometry<S>& geometry, const HeatParams<S>& heat,
                      const ThreePhaseParams<S>& kinetics) {
  const Drive<S> room{S(room_K), S(150e6)};
  return {S(1.74) * clamp_reach_m(geometry, heat) / geometry.length_m,
          ThreePhase<S>::phases(ThreePhase<S>::rest(kinetics, room))};
}

/// The wire's middle as one body. The middle of a fin of length L between two cold clamps is cooler
/// than without them by the factor 1 - 1/cosh(L/2λ); the loss is raised by the inverse of this
/// factor.
template <class S>
ThermalBody<S> thermal_body(const Geometry<S>& geometry, const HeatParams<S>& heat) {
  using std::exp;
  const S mass_kg = heat.density_kg_m3 * geometry.area_m2() * geometry.length_m;
  S clamps = S(1);
  if (S(0) < heat.clamp_conductivity_W_mK) {
    const S half = geometry.length_m / (S(2) * clamp_reach_m(geometry, heat));
    // 1 - 1/cosh x = (1 - e^-x)²/(1 + e^-2x)
    const S cold = exp(-half);
    const S warm = S(1) - cold;
    clamps = half < S(20) ? (S(1) + cold * cold) / (warm * warm) : S(1);
  }
  return {mass_kg * heat.specific_heat_J_kgK, mass_kg * heat.latent_m2a_J_kg,
          mass_kg * heat.latent_r2a_J_kg, clamps * geometry.surface_m2() * heat.convection_W_m2K,
          clamps * geometry.surface_m2() * heat.convection_W_m2K2};
}

}  // namespace smaservo
