#pragma once
// A wire divided along its length: heat flows between the segments and into two cold clamps, each
// segment has its own temperature and history. The plant behind simulated traces; the observers
// know only the lumped one.

#include <array>
#include <cmath>
#include <cstddef>

#include "model/kinetics.hpp"
#include "model/wire/convection.hpp"
#include "model/wire/material.hpp"
#include "model/wire/three_phase/three_phase_row.hpp"
#include "model/wire/wire.hpp"

namespace smaservo {

/// A wire of `segments` parts, each with the kinetics K. All functions are static; what changes is
/// in State.
template <Kinetics K, std::size_t segments>
struct DistributedPlant {
  using S = typename K::Scalar;
  static_assert(segments >= 2);
  template <class T>
  using PerSegment = std::array<T, segments>;

  /// Constants of a wire; lengths and masses above 0.
  struct Params {
    PerSegment<typename K::Params> kinetics;  ///< may scatter along the wire
    Material<S> material;
    HeatParams<S> heat;
    Geometry<S> geometry;
    PerSegment<S> length_m;      ///< sums up to geometry.length_m
    S specific_heat_1_K = S(0);  ///< relative increase of the specific heat per kelvin above 25 °C
    /// 0: the material's own mixture of resistivities; above 0: the share of the way from phases in
    /// series to phases in parallel (1).
    S parallel_share = S(0);
    /// Thermal resistance between the wire's end and the ambient temperature that a clamp adds, as
    /// a length of wire; 0: the clamps are at ambient temperature.
    S clamp_resistance_m = S(0);
    /// Share of martensite's strain that is missing without stress; it comes with stress as
    /// 1 - exp(-σ/σ_H), with σ_H > 0.
    S strain_deficit = S(0);
    S strain_saturation_Pa = S(1);
    ConvectionTable<S> convection;
  };

  /// The segments' temperatures and fractions side by side: loops over them run in vector
  /// registers.
  struct Profile {
    PerSegment<S> temperature_K, martensite, r_phase;
    S stress_Pa;  ///< the same in all segments
  };

  /// What changes; trivially copyable.
  struct State {
    PerSegment<typename K::State> kinetics;
    /// Heat error of each segment's last linearisation, carried into the next step.
    PerSegment<S> heat_J;
    Profile profile;  ///< copies from `kinetics`
    typename Row<K, segments>::Kept kept;
  };

  /// What surrounds the wire during one step.
  struct Surroundings {
    S stress_Pa;
    S ambient_K;  ///< temperature of the air and of the clamps
  };

  /// A wire that was cooled to this temperature at this stress from far above. Cost: one rest() of
  /// the kinetics for each segment.
  static State rest(const Params& p, const Drive<S>& u) {
    State s{};
    for (std::size_t i = 0; i < segments; ++i) {
      s.kinetics[i] = K::rest(p.kinetics[i], u);
      s.heat_J[i] = S(0);
    }
    s.profile = profile_of(s.kinetics);
    return s;
  }

  /// Moves all segments to this drive without a heat balance.
  static void soak(const Params& p, State& s, const Drive<S>& u) {
    for (std::size_t i = 0; i < segments; ++i) {
      K::advance(p.kinetics[i], s.kinetics[i], u);
    }
    s.profile = profile_of(s.kinetics);
  }

  /// Elongation of the whole wire, over its length.
  static S strain(const Params& p, const State& s) {
    const PerSegment<S> each = strains(p, s.profile);
    S sum = S(0);
    for (std::size_t i = 0; i < segments; ++i) {
      sum += each[i] * p.length_m[i];
    }
    return sum / p.geometry.length_m;
  }

  /// Resistance of the whole wire.
  static S resistance_ohm(const Params& p, const State& s) {
    S sum = S(0);
    for (const S& each_ohm : resistances_ohm(p, s.profile)) {
      sum += each_ohm;
    }
    return sum;
  }

  /// Temperature of a segment, less than `segments`.
  static S temperature_K(const State& s, std::size_t segment) {
    return s.profile.temperature_K[segment];
  }

  /// Like Plant::advance() for each segment, with the conduction between neighbours solved
  /// together, implicitly. There are no substeps: dt_s up to 1 ms. Convection is Churchill and
  /// Chu's times `draught`, computed at the start of the step.
  static void advance(const Params& p, State& s, const S& current_A, const Surroundings& around,
                      const S& draught, const S& dt_s) {
    const Profile before = s.profile;
    const Balance b = balance(p, s, before, current_A, around, draught, dt_s);
    const PerSegment<S> dT = solve(b);
    PerSegment<S> to_K;
    for (std::size_t i = 0; i < segments; ++i) {
      to_K[i] = before.temperature_K[i] + dT[i];
    }
    if constexpr (TimedKinetics<K>) {
      for (std::size_t i = 0; i < segments; ++i) {
        K::advance(p.kinetics[i], s.kinetics[i], {to_K[i], around.stress_Pa}, dt_s);
      }
    } else {
      Row<K, segments>::advance(p.kinetics, s.kinetics, s.kept, to_K, around.stress_Pa);
    }
    s.profile = profile_of(s.kinetics);
    const Profile& after = s.profile;
    const PerLink flow_J = flows_J(b, dT, S(0));
    for (std::size_t i = 0; i < segments; ++i) {
      // The specific heat is linear in temperature: its mean over the step is its value at the
      // middle.
      const S capacity_J_K =
          b.mass_kg[i] * specific_heat_J_kgK(p, after.temperature_K[i] - S(0.5) * dT[i]);
      s.heat_J[i] =
          b.heat_J[i] - (capacity_J_K + b.loss_J_K[i]) * dT[i] - flow_J[i] + flow_J[i + 1] +
          b.mass_kg[i] * (p.heat.latent_m2a_J_kg * (after.martensite[i] - before.martensite[i]) +
                          p.heat.latent_r2a_J_kg * (after.r_phase[i] - before.r_phase[i]));
    }
  }

 private:
  static Profile profile_of(const PerSegment<typename K::State>& kinetics) {
    Profile now;
    for (std::size_t i = 0; i < segments; ++i) {
      const Phases<S> z = K::phases(kinetics[i]);
      now.temperature_K[i] = K::drive(kinetics[i]).temperature_K;
      now.martensite[i] = z.martensite;
      now.r_phase[i] = z.r_phase;
    }
    now.stress_Pa = K::drive(kinetics[0]).stress_Pa;
    return now;
  }

  /// One value for each link between a segment and its left neighbour or clamp; the last one is the
  /// right clamp.
  using PerLink = std::array<S, segments + 1>;

  /// The heat balance of one step, linear in the changes of the temperatures.
  struct Balance {
    PerSegment<S> mass_kg, heat_J, effective_J_K, loss_J_K;
    PerLink link_J_K;
  };

  static Balance balance(const Params& p, State& s, const Profile& now, const S& current_A,
                         const Surroundings& around, const S& draught, const S& dt_s) {
    Balance b;
    const S area = p.geometry.area_m2();
    const S conductance = p.heat.clamp_conductivity_W_mK * area * dt_s;
    b.link_J_K[0] = conductance / (S(0.5) * p.length_m[0] + p.clamp_resistance_m);
    b.link_J_K[segments] = conductance / (S(0.5) * p.length_m[segments - 1] + p.clamp_resistance_m);
    for (std::size_t i = 1; i < segments; ++i) {
      b.link_J_K[i] = conductance / (S(0.5) * (p.length_m[i - 1] + p.length_m[i]));
    }
    const PerSegment<S> h =
        p.convection.h_W_m2K(p.geometry.diameter_m, now.temperature_K, around.ambient_K);
    const S surface_s = draught * p.geometry.surface_m2() / p.geometry.length_m * dt_s;
    const PerSegment<S> ohm = resistances_ohm(p, now);
    const S joule = current_A * current_A * dt_s;
    const PerLink flow_J = flows_J(b, now.temperature_K, around.ambient_K);
    for (std::size_t i = 0; i < segments; ++i) {
      b.mass_kg[i] = p.heat.density_kg_m3 * area * p.length_m[i];
      b.loss_J_K[i] = h[i] * surface_s * p.length_m[i];
      b.heat_J[i] = s.heat_J[i] + joule * ohm[i] -
                    b.loss_J_K[i] * (now.temperature_K[i] - around.ambient_K) - flow_J[i] +
                    flow_J[i + 1];
    }
    PerSegment<Heading> heading;
    for (std::size_t i = 0; i < segments; ++i) {
      heading[i] = S(0) < b.heat_J[i] ? Heading::heating : Heading::cooling;
    }
    const auto rates = Row<K, segments>::rates(p.kinetics, s.kinetics, s.kept, heading);
    for (std::size_t i = 0; i < segments; ++i) {
      const ThermalBody<S> body{b.mass_kg[i] * specific_heat_J_kgK(p, now.temperature_K[i]),
                                b.mass_kg[i] * p.heat.latent_m2a_J_kg,
                                b.mass_kg[i] * p.heat.latent_r2a_J_kg, S(0), S(0)};
      b.effective_J_K[i] = body.effective_capacity_J_K(rates[i]);
    }
    return b;
  }

  /// The flow through each link from the right neighbour to the left one; `ends` is the value at
  /// the clamps.
  static PerLink flows_J(const Balance& b, const PerSegment<S>& value, const S& ends) {
    PerLink flow;
    flow[0] = b.link_J_K[0] * (value[0] - ends);
    for (std::size_t i = 1; i < segments; ++i) {
      flow[i] = b.link_J_K[i] * (value[i] - value[i - 1]);
    }
    flow[segments] = b.link_J_K[segments] * (ends - value[segments - 1]);
    return flow;
  }

  /// Gaussian elimination on the symmetric tridiagonal system, from both ends to the middle: two
  /// chains of divisions that are independent of each other.
  static PerSegment<S> solve(const Balance& b) {
    constexpr std::size_t middle = segments / 2;
    PerSegment<S> diagonal, factor, right = b.heat_J;
    for (std::size_t i = 0; i < segments; ++i) {
      diagonal[i] = b.effective_J_K[i] + b.loss_J_K[i] + b.link_J_K[i] + b.link_J_K[i + 1];
    }
    const auto eliminate = [&](std::size_t from, std::size_t to, const S& link) {
      const S inverse = S(1) / diagonal[from];
      factor[from] = link * inverse;
      diagonal[to] -= link * link * inverse;
      right[to] += factor[from] * right[from];
      right[from] *= inverse;
    };
    for (std::size_t i = 0; i < middle; ++i) {
      eliminate(i, i + 1, b.link_J_K[i + 1]);
    }
    for (std::size_t i = segments - 1; i > middle; --i) {
      eliminate(i, i - 1, b.link_J_K[i]);
    }
    PerSegment<S> dT;
    dT[middle] = right[middle] / diagonal[middle];
    for (std::size_t i = middle; i > 0; --i) {
      dT[i - 1] = right[i - 1] + factor[i - 1] * dT[i];
    }
    for (std::size_t i = middle + 1; i < segments; ++i) {
      dT[i] = right[i] + factor[i] * dT[i - 1];
    }
    return dT;
  }

  static S specific_heat_J_kgK(const Params& p, const S& T) {
    return p.heat.specific_heat_J_kgK * (S(1) + p.specific_heat_1_K * (T - S(room_K)));
  }
  static PerSegment<S> strains(const Params& p, const Profile& now) {
    StrainSlopes<S> by = strain_slopes(p.material, now.stress_Pa);
    if (S(0) < p.strain_deficit) {
      by.martensite -= p.strain_deficit * std::exp(-now.stress_Pa / p.strain_saturation_Pa) *
                       p.material.martensite.strain;
    }
    PerSegment<S> strain;
    for (std::size_t i = 0; i < segments; ++i) {
      strain[i] = by.austenite + now.martensite[i] * by.martensite + now.r_phase[i] * by.r_phase;
    }
    return strain;
  }
  static PerSegment<S> resistivities(const Material<S>& m, const Profile& now) {
    PerSegment<S> rho;
    for (std::size_t i = 0; i < segments; ++i) {
      rho[i] = resistivity(m, {now.martensite[i], now.r_phase[i]},
                           Drive<S>{now.temperature_K[i], now.stress_Pa})
                   .value;
    }
    return rho;
  }
  static PerSegment<S> mixed_resistivities(const Params& p, const Profile& now) {
    if (!(S(0) < p.parallel_share)) {
      return resistivities(p.material, now);
    }
    Material<S> m = p.material;
    m.mixture = Mixture::series;
    PerSegment<S> rho = resistivities(m, now);
    m.mixture = Mixture::parallel;
    const PerSegment<S> parallel = resistivities(m, now);
    for (std::size_t i = 0; i < segments; ++i) {
      rho[i] += p.parallel_share * (parallel[i] - rho[i]);
    }
    return rho;
  }
  static PerSegment<S> resistances_ohm(const Params& p, const Profile& now) {
    PerSegment<S> ohm = mixed_resistivities(p, now);
    const PerSegment<S> strain = strains(p, now);
    const S per_area_1_m2 = S(1) / p.geometry.area_m2();
    for (std::size_t i = 0; i < segments; ++i) {
      ohm[i] = smaservo::resistance_ohm(ohm[i], p.length_m[i] * per_area_1_m2, strain[i]);
    }
    return ohm;
  }
};

}  // namespace smaservo
