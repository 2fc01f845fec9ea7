#pragma once
// The parameters of the wire. None has a default: a device without its wire is not configured.

#include "firmware/parameters/parameter.hpp"

namespace smaservo {

inline constexpr std::string_view memory_names[] = {"plain", "return-point"};
inline constexpr std::string_view mixture_names[] = {"series", "parallel"};

template <class S>
constexpr auto wire_rows() {
  constexpr auto w = &Settings<S>::wire;
  constexpr auto g = &Wire<S>::geometry;
  constexpr auto k = &Wire<S>::kinetics;
  using K = ThreePhaseParams<S>;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      real<Member<S, w, g, &Geometry<S>::length_m>>({0x2110, 1}, "wire.length_m", kind::length,
                                                    when, 1e-3F, no_default, 100,
                                                    "between the clamps"),
      real<Member<S, w, g, &Geometry<S>::diameter_m>>({0x2110, 2}, "wire.diameter_m", kind::length,
                                                      when, 5e-6F, no_default, 5e-3F,
                                                      "of the bare wire"),
      real<Member<S, w, &Wire<S>::nominal_stroke>>({0x2110, 3}, "wire.nominal_stroke", kind::number,
                                                   when, 1e-3F, no_default, 0.2F,
                                                   "strain that errors are related to"),
      choice<Member<S, w, k, &K::memory>>({0x2110, 4}, "wire.memory", memory_names, when,
                                          Memory::return_point, "how inner loops behave"),
      real<Member<S, w, k, &K::smallest_reversal_K>>(
          {0x2110, 5}, "wire.smallest_reversal_K", kind::temperature_difference, when, 0,
          no_default, 5, "a reversal below it does not count"),
      boolean<Member<S, w, k, &K::separate_r2a>>({0x2110, 6}, "wire.separate_r2a", when, false,
                                                 "R2A has a surface of its own, not m2a's"),
      boolean<Member<S, w, k, &K::separate_r2m>>({0x2110, 7}, "wire.separate_r2m", when, false,
                                                 "R2M has a surface of its own, not a2m's"),
  });
}

/// Where a surface's coefficients are: in a surface of its own, or in a lane of the pair.
template <class S, auto surface>
struct OwnSurface {
  using Scalar = S;
  using Of = Surface<S>;
  template <auto polynomial, std::size_t i>
  using At = Coefficient<S, surface, polynomial, i>;
};
template <class S, Lane lane>
struct PairLane {
  using Scalar = S;
  using Of = Surface<Pair<S>>;
  template <auto polynomial, std::size_t i>
  using At = LaneCoefficient<S, lane, polynomial, i>;
};

template <class Where, auto polynomial, std::size_t i, class S = typename Where::Scalar>
constexpr Parameter<S> coefficient(Key key, Path path, Kind kind, float least, float greatest,
                                   std::string_view meaning, Needs needs) {
  return real<typename Where::template At<polynomial, i>>(
      key, path, kind, Change::without_current, least, no_default, greatest, meaning, needs);
}

/// The ten coefficients of one transformation process, by power of the stress in Pa.
template <class Where, class S = typename Where::Scalar>
constexpr auto process_rows(std::uint16_t x, const char* p, Needs needs = Needs::nothing) {
  using Q = typename Where::Of;
  constexpr Kind K = kind::temperature;
  constexpr Kind K_Pa = kind::kelvin_per_stress;
  constexpr Kind K_Pa2 = kind::kelvin_per_square_stress;
  constexpr Kind per_Pa = kind::per_stress;
  constexpr auto start = &Q::start_K;
  constexpr auto finish = &Q::finish_K;
  constexpr auto curvature = &Q::curvature;
  constexpr auto turning = &Q::turning;
  return std::to_array<Parameter<S>>({
      coefficient<Where, start, 0>({x, 1}, {p, ".start_0_K"}, K, 150, 600, "T_s at 0 Pa", needs),
      coefficient<Where, start, 1>({x, 2}, {p, ".start_1_K_Pa"}, K_Pa, -1e-5F, 1e-5F,
                                   "T_s, by stress", needs),
      coefficient<Where, start, 2>({x, 3}, {p, ".start_2_K_Pa2"}, K_Pa2, -1e-13F, 1e-13F,
                                   "T_s, by its square", needs),
      coefficient<Where, finish, 0>({x, 4}, {p, ".finish_0_K"}, K, 150, 600, "T_f at 0 Pa", needs),
      coefficient<Where, finish, 1>({x, 5}, {p, ".finish_1_K_Pa"}, K_Pa, -1e-5F, 1e-5F,
                                    "T_f, by stress", needs),
      coefficient<Where, finish, 2>({x, 6}, {p, ".finish_2_K_Pa2"}, K_Pa2, -1e-13F, 1e-13F,
                                    "T_f, by its square", needs),
      coefficient<Where, curvature, 0>({x, 7}, {p, ".curvature_0"}, kind::number, 1e-3F, 30,
                                       "curvature at 0 Pa", needs),
      coefficient<Where, curvature, 1>({x, 8}, {p, ".curvature_1_1_Pa"}, per_Pa, -1e-6F, 1e-6F,
                                       "curvature, by stress", needs),
      coefficient<Where, turning, 0>({x, 9}, {p, ".turning_0"}, kind::number, 0.05F, 0.95F,
                                     "fraction at the turning point, at 0 Pa", needs),
      coefficient<Where, turning, 1>({x, 10}, {p, ".turning_1_1_Pa"}, per_Pa, -1e-7F, 1e-7F,
                                     "fraction at the turning point, by stress", needs),
  });
}

template <class S, auto phase>
constexpr auto phase_rows(std::uint16_t x, const char* p) {
  constexpr auto w = &Settings<S>::wire;
  constexpr auto m = &Wire<S>::material;
  using P = Phase<S>;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      real<Member<S, w, m, phase, &P::strain>>({x, 1}, {p, ".strain"}, kind::number, when, -0.05F,
                                               no_default, 0.2F, "without stress"),
      real<Member<S, w, m, phase, &P::modulus_Pa>>({x, 2}, {p, ".modulus_Pa"}, kind::stress, when,
                                                   1e9F, no_default, 1e12F, "Young's modulus"),
      real<Member<S, w, m, phase, &P::resistivity_ohm_m>>(
          {x, 3}, {p, ".resistivity_ohm_m"}, kind::resistivity, when, 1e-8F, no_default, 1e-4F,
          "at the reference temperature, without stress"),
      real<Member<S, w, m, phase, &P::resistivity_ohm_m_K>>(
          {x, 4}, {p, ".resistivity_ohm_m_K"}, kind::resistivity_slope, when, -1e-6F, no_default,
          1e-6F, "its slope over temperature"),
      real<Member<S, w, m, phase, &P::resistivity_ohm_m_Pa>>(
          {x, 5}, {p, ".resistivity_ohm_m_Pa"}, kind::resistivity_per_stress, when, -1e-12F,
          no_default, 1e-12F, "its slope over stress"),
  });
}

template <class S>
constexpr auto material_rows() {
  constexpr auto w = &Settings<S>::wire;
  constexpr auto m = &Wire<S>::material;
  using M = Material<S>;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      real<Member<S, w, m, &M::reference_K>>({0x2119, 1}, "wire.material.reference_K",
                                             kind::temperature, when, 200, no_default, 400,
                                             "of the resistivities"),
      choice<Member<S, w, m, &M::mixture>>({0x2119, 2}, "wire.material.mixture", mixture_names,
                                           when, Mixture::series,
                                           "how the phases share the current"),
  });
}

template <class S>
constexpr auto heat_rows() {
  constexpr auto w = &Settings<S>::wire;
  constexpr auto h = &Wire<S>::heat;
  using H = HeatParams<S>;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      real<Member<S, w, h, &H::density_kg_m3>>({0x211A, 1}, "wire.heat.density_kg_m3",
                                               kind::density, when, 1e3F, no_default, 2e4F,
                                               "of the alloy"),
      real<Member<S, w, h, &H::specific_heat_J_kgK>>({0x211A, 2}, "wire.heat.specific_heat_J_kgK",
                                                     kind::specific_heat, when, 50, no_default,
                                                     5000, "without transformation"),
      real<Member<S, w, h, &H::latent_m2a_J_kg>>({0x211A, 3}, "wire.heat.latent_m2a_J_kg",
                                                 kind::specific_energy, when, 0, no_default, 1e5F,
                                                 "martensite to austenite"),
      real<Member<S, w, h, &H::latent_r2a_J_kg>>({0x211A, 4}, "wire.heat.latent_r2a_J_kg",
                                                 kind::specific_energy, when, 0, no_default, 1e5F,
                                                 "R-phase to austenite"),
      real<Member<S, w, h, &H::convection_W_m2K>>({0x211A, 5}, "wire.heat.convection_W_m2K",
                                                  kind::heat_transfer, when, 0.1F, no_default, 1e5F,
                                                  "h at ambient temperature"),
      real<Member<S, w, h, &H::convection_W_m2K2>>({0x211A, 6}, "wire.heat.convection_W_m2K2",
                                                   kind::heat_transfer_slope, when, 0, no_default,
                                                   1e3F, "what h gains per kelvin above it"),
      real<Member<S, w, h, &H::clamp_conductivity_W_mK>>(
          {0x211A, 7}, "wire.heat.clamp_conductivity_W_mK", kind::conductivity, when, 0, no_default,
          500, "of the wire, towards its cold clamps; 0 without"),
  });
}

template <class S>
constexpr auto accuracy_rows() {
  constexpr auto w = &Settings<S>::wire;
  constexpr auto a = &Wire<S>::accuracy;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      real<Member<S, w, a, &Accuracy<S>::strain>>(
          {0x211B, 1}, "wire.accuracy.strain", kind::number, when, 1e-5F, no_default, 0.1F,
          "root mean square of what the model, from power and load alone, is off"),
      real<Member<S, w, a, &Accuracy<S>::resistance>>(
          {0x211B, 2}, "wire.accuracy.resistance", kind::number, when, 1e-5F, no_default, 0.1F,
          "and of the resistance at a given strain, relative"),
  });
}

/// What the maker allows; the device's own limits are at 2020h.
template <class S>
constexpr auto wire_limit_rows() {
  constexpr auto w = &Settings<S>::wire;
  constexpr auto l = &Wire<S>::limits;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      real<Member<S, w, l, &Limits<S>::current_A>>({0x211C, 1}, "wire.limits.current_A",
                                                   kind::current, when, 1e-4F, no_default, 100,
                                                   "the maker's, in still air"),
      real<Member<S, w, l, &Limits<S>::stress_Pa>>({0x211C, 2}, "wire.limits.stress_Pa",
                                                   kind::stress, when, 1e5F, no_default, 5e9F,
                                                   "the maker's"),
      real<Member<S, w, l, &Limits<S>::temperature_K>>({0x211C, 3}, "wire.limits.temperature_K",
                                                       kind::temperature, when, 300, no_default,
                                                       700, "of the wire"),
  });
}

}  // namespace smaservo
