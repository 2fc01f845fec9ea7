#pragma once
// A wire divided along its length: heat flows between the segments and into two cold clamps, each
// segment has its own temperature and history. The plant behind simulated traces; the observers
// know only the lumped one.

#include <array>
#include <cstddef>

#include "model/heat.hpp"
#include "model/kinetics.hpp"
#include "model/material.hpp"
#include "model/wire.hpp"

namespace smaservo {

template <Kinetics K, std::size_t segments>
struct DistributedPlant {
  using S = typename K::Scalar;
  static_assert(segments >= 2);
  template <class T>
  using PerSegment = std::array<T, segments>;

  struct Params {
    PerSegment<typename K::Params> kinetics;  ///< may scatter along the wire
    Material<S> material;
    HeatParams<S> heat;
    Geometry<S> geometry;
    PerSegment<S> length_m;      ///< sums up to geometry.length_m
    S specific_heat_1_K = S(0);  ///< what the specific heat gains per kelvin above 25 °C, relative
    S parallel_share = S(0);     ///< 0: the material's mixture of resistivities; else its way from
                                 ///< series to parallel, up to 1
  };

  struct State {
    PerSegment<typename K::State> kinetics;
    PerSegment<S> heat_J;  ///< what a segment's last linearisation could not place
  };

  /// What surrounds the wire during one step.
  struct Surroundings {
    S stress_Pa;
    S ambient_K;  ///< of the air and of the clamps
  };

  static State rest(const Params& p, const Drive<S>& u) {
    State s{};
    for (std::size_t i = 0; i < segments; ++i) {
      s.kinetics[i] = K::rest(p.kinetics[i], u);
      s.heat_J[i] = S(0);
    }
    return s;
  }

  static S strain(const Params& p, const State& s) {
    S sum = S(0);
    for (std::size_t i = 0; i < segments; ++i) {
      sum = sum + segment_strain(p, s, i) * p.length_m[i];
    }
    return sum / p.geometry.length_m;
  }

  static S resistance_ohm(const Params& p, const State& s) {
    S sum = S(0);
    for (std::size_t i = 0; i < segments; ++i) {
      sum = sum + segment_resistance_ohm(p, s, i);
    }
    return sum;
  }

  static S temperature_K(const State& s, std::size_t segment) {
    return K::drive(s.kinetics[segment]).temperature_K;
  }

  /// As Plant::advance() for each segment, with the conduction between neighbours solved along
  /// with it, implicitly. The step is not divided: dt_s up to 1 ms. Convection is Churchill and
  /// Chu's times `draught`, taken at the step's start.
  static void advance(const Params& p, State& s, const S& current_A, const Surroundings& around,
                      const S& draught, const S& dt_s) {
    const Balance b = balance(p, s, current_A, around, draught, dt_s);
    const PerSegment<S> dT = solve(b);
    for (std::size_t i = 0; i < segments; ++i) {
      const Phases<S> before = K::phases(s.kinetics[i]);
      K::advance(p.kinetics[i], s.kinetics[i], {temperature_K(s, i) + dT[i], around.stress_Pa});
      const Phases<S> after = K::phases(s.kinetics[i]);
      const S left = i == 0 ? dT[i] : dT[i] - dT[i - 1];
      const S right = i + 1 == segments ? dT[i] : dT[i] - dT[i + 1];
      // The specific heat is a line: its mean over the step is that of the step's middle.
      const S capacity_J_K =
          b.mass_kg[i] * specific_heat_J_kgK(p, temperature_K(s, i) - S(0.5) * dT[i]);
      s.heat_J[i] =
          b.heat_J[i] - (capacity_J_K + b.loss_J_K[i]) * dT[i] - b.link_J_K[i] * left -
          b.link_J_K[i + 1] * right +
          b.mass_kg[i] * (p.heat.latent_m2a_J_kg * (after.martensite - before.martensite) +
                          p.heat.latent_r2a_J_kg * (after.r_phase - before.r_phase));
    }
  }

 private:
  /// One step's heat, linear in the changes of the temperatures.
  struct Balance {
    PerSegment<S> mass_kg, heat_J, effective_J_K, loss_J_K;
    std::array<S, segments + 1> link_J_K;  ///< to the left neighbour or clamp; last: right clamp
  };

  static Balance balance(const Params& p, const State& s, const S& current_A,
                         const Surroundings& around, const S& draught, const S& dt_s) {
    Balance b;
    const S area = p.geometry.area_m2();
    const S conductance = p.heat.clamp_conductivity_W_mK * area * dt_s;
    b.link_J_K[0] = conductance / (S(0.5) * p.length_m[0]);
    b.link_J_K[segments] = conductance / (S(0.5) * p.length_m[segments - 1]);
    for (std::size_t i = 1; i < segments; ++i) {
      b.link_J_K[i] = conductance / (S(0.5) * (p.length_m[i - 1] + p.length_m[i]));
    }
    for (std::size_t i = 0; i < segments; ++i) {
      const S T = temperature_K(s, i);
      const S left_K = i == 0 ? around.ambient_K : temperature_K(s, i - 1);
      const S right_K = i + 1 == segments ? around.ambient_K : temperature_K(s, i + 1);
      const S surface = p.geometry.surface_m2() * p.length_m[i] / p.geometry.length_m;
      const S h = draught * natural_convection_W_m2K(p.geometry.diameter_m, T, around.ambient_K);
      b.mass_kg[i] = p.heat.density_kg_m3 * area * p.length_m[i];
      const S capacity_J_K = b.mass_kg[i] * specific_heat_J_kgK(p, T);
      b.loss_J_K[i] = h * surface * dt_s;
      b.heat_J[i] = s.heat_J[i] + current_A * current_A * segment_resistance_ohm(p, s, i) * dt_s -
                    b.loss_J_K[i] * (T - around.ambient_K) - b.link_J_K[i] * (T - left_K) -
                    b.link_J_K[i + 1] * (T - right_K);
      const Heading heading = S(0) < b.heat_J[i] ? Heading::heating : Heading::cooling;
      const PhaseRates<S> rates = K::rates(p.kinetics[i], s.kinetics[i], heading);
      const ThermalBody<S> body{capacity_J_K, b.mass_kg[i] * p.heat.latent_m2a_J_kg,
                                b.mass_kg[i] * p.heat.latent_r2a_J_kg, S(0), S(0)};
      b.effective_J_K[i] = body.effective_capacity_J_K(rates);
    }
    return b;
  }

  /// Thomas' algorithm on the symmetric tridiagonal system.
  static PerSegment<S> solve(const Balance& b) {
    PerSegment<S> diagonal, right = b.heat_J;
    for (std::size_t i = 0; i < segments; ++i) {
      diagonal[i] = b.effective_J_K[i] + b.loss_J_K[i] + b.link_J_K[i] + b.link_J_K[i + 1];
    }
    for (std::size_t i = 1; i < segments; ++i) {
      const S f = b.link_J_K[i] / diagonal[i - 1];
      diagonal[i] = diagonal[i] - f * b.link_J_K[i];
      right[i] = right[i] + f * right[i - 1];
    }
    PerSegment<S> dT;
    dT[segments - 1] = right[segments - 1] / diagonal[segments - 1];
    for (std::size_t i = segments - 1; i > 0; --i) {
      dT[i - 1] = (right[i - 1] + b.link_J_K[i] * dT[i]) / diagonal[i - 1];
    }
    return dT;
  }

  static S segment_strain(const Params& p, const State& s, std::size_t i) {
    return smaservo::strain(p.material, K::phases(s.kinetics[i]),
                            K::drive(s.kinetics[i]).stress_Pa);
  }
  static S specific_heat_J_kgK(const Params& p, const S& T) {
    return p.heat.specific_heat_J_kgK * (S(1) + p.specific_heat_1_K * (T - S(298.15)));
  }
  static S mixed_resistivity(const Params& p, const Phases<S>& z, const Drive<S>& u) {
    if (!(S(0) < p.parallel_share)) {
      return resistivity(p.material, z, u).value;
    }
    Material<S> m = p.material;
    m.mixture = Mixture::series;
    const S series = resistivity(m, z, u).value;
    m.mixture = Mixture::parallel;
    return series + p.parallel_share * (resistivity(m, z, u).value - series);
  }
  static S segment_resistance_ohm(const Params& p, const State& s, std::size_t i) {
    const Drive<S> u = K::drive(s.kinetics[i]);
    return smaservo::resistance_ohm(mixed_resistivity(p, K::phases(s.kinetics[i]), u),
                                    p.length_m[i] / p.geometry.area_m2(), segment_strain(p, s, i));
  }
};

}  // namespace smaservo
