#pragma once
// Strain and resistance of the mixture of phases.
// Source: paper 000, 'Model layout' and 'Stress dependence of the material parameters', figure 18;
// 001 eq. 19 and 20; 002 eq. 35.

#include "model/kinetics.hpp"

namespace smaservo {

/// One phase by itself.
template <class S>
struct Phase {
  S strain;                ///< ε_0, elongation without stress, counted from austenite
  S modulus_Pa;            ///< E
  S resistivity_ohm_m;     ///< ρ_0, at Material::reference_K and without stress
  S resistivity_ohm_m_K;   ///< k, its slope over temperature
  S resistivity_ohm_m_Pa;  ///< q, its slope over stress
};

/// How the phases share the current: in series (000) or in parallel (001 eq. 20).
enum class Mixture : unsigned char { series, parallel };

template <class S>
struct Material {
  Phase<S> martensite, r_phase, austenite;
  S reference_K;
  Mixture mixture = Mixture::series;
};

/// Derivatives of the strain by the fractions at constant stress, where a gain of one fraction is a
/// loss of austenite.
template <class S>
struct StrainSlopes {
  S austenite;  ///< the strain of austenite itself
  S martensite, r_phase;
};

template <class S>
constexpr StrainSlopes<S> strain_slopes(const Material<S>& m, const S& stress_Pa) {
  const auto of = [&](const Phase<S>& phase) {
    return phase.strain + stress_Pa / phase.modulus_Pa;
  };
  const S a = of(m.austenite);
  return {a, of(m.martensite) - a, of(m.r_phase) - a};
}

/// Elongation: ε = Σ z_i (ε_i0 + σ/E_i), phases in series (000).
template <class S>
constexpr S strain(const Material<S>& m, const Phases<S>& z, const S& stress_Pa) {
  const StrainSlopes<S> by = strain_slopes(m, stress_Pa);
  return by.austenite + z.martensite * by.martensite + z.r_phase * by.r_phase;
}

/// Resistivity with its derivatives; those by the fractions are defined as in StrainSlopes.
template <class S>
struct Resistivity {
  S value;
  S per_K;
  S per_martensite, per_r_phase;
};

/// ρ_i = ρ_i0 + k_i (T - T_0) + q_i σ. Series: ρ = Σ z_i ρ_i (000); parallel: 1/ρ = Σ z_i/ρ_i
/// (001 eq. 20).
template <class S>
constexpr Resistivity<S> resistivity(const Material<S>& m, const Phases<S>& z, const Drive<S>& u) {
  const S above = u.temperature_K - m.reference_K;
  const auto of = [&](const Phase<S>& phase) {
    return phase.resistivity_ohm_m + phase.resistivity_ohm_m_K * above +
           phase.resistivity_ohm_m_Pa * u.stress_Pa;
  };
  const S rho_m = of(m.martensite);
  const S rho_r = of(m.r_phase);
  const S rho_a = of(m.austenite);
  const S k_m = m.martensite.resistivity_ohm_m_K;
  const S k_r = m.r_phase.resistivity_ohm_m_K;
  const S k_a = m.austenite.resistivity_ohm_m_K;
  const S a = z.austenite();
  if (m.mixture == Mixture::series) {
    return {rho_a + z.martensite * (rho_m - rho_a) + z.r_phase * (rho_r - rho_a),
            k_a + z.martensite * (k_m - k_a) + z.r_phase * (k_r - k_a), rho_m - rho_a,
            rho_r - rho_a};
  }
  const S g_m = S(1) / rho_m;
  const S g_r = S(1) / rho_r;
  const S g_a = S(1) / rho_a;
  const S rho = S(1) / (z.martensite * g_m + z.r_phase * g_r + a * g_a);
  return {rho,
          rho * rho *
              (z.martensite * g_m * g_m * k_m + z.r_phase * g_r * g_r * k_r + a * g_a * g_a * k_a),
          rho * rho * (g_a - g_m), rho * rho * (g_a - g_r)};
}

/// R = ρ L_0/A_0 (1 + 2 ε): a wire that stretches keeps its volume (001 eq. 19, 002 eq. 35).
template <class S>
constexpr S resistance_ohm(const S& resistivity_ohm_m, const S& length_per_area_1_m,
                           const S& strain) {
  return resistivity_ohm_m * length_per_area_1_m * (S(1) + strain + strain);
}

}  // namespace smaservo
