#pragma once
// Heat balance of a wire in air: power in, convection and clamps out, latent heat in between.
// Source: paper 000, 'Model layout' (the energy balance as a block); 001 eq. 1; 003 eq. 1. The
// equation with latent heat is reconstructed in model/README.md.

#include <cmath>

#include "model/kinetics.hpp"
#include "model/units.hpp"

namespace smaservo {

/// Heat transfer coefficient of a horizontal wire in still air, W/(m² K), after Churchill and Chu
/// (1975) with the properties of air at the film temperature and 101325 Pa. Cost:
/// five powers, so for defaults and simulated wires, not for loops. diameter_m 10e-6..1e-3,
/// temperatures 230..600 K; defined where both temperatures are equal, too.
template <class S>
S natural_convection_W_m2K(S diameter_m, S temperature_K, S ambient_K) {
  using std::abs;
  using std::pow;
  using std::sqrt;
  const S film = S(0.5) * (temperature_K + ambient_K);
  // Sutherland's formulas and the ideal gas
  const S viscosity_Pa_s = S(1.458e-6) * film * sqrt(film) / (film + S(110.4));
  const S conductivity_W_mK =
      S(2.64638e-3) * film * sqrt(film) / (film + S(245.4) * pow(S(10), S(-12) / film));
  const S density_kg_m3 = S(101325) / (S(287.05) * film);
  const S nu = viscosity_Pa_s / density_kg_m3;
  const S Pr = viscosity_Pa_s * S(1006) / conductivity_W_mK;
  const S Ra = S(9.80665) / film * abs(temperature_K - ambient_K) * diameter_m * diameter_m *
               diameter_m / (nu * nu) * Pr;
  // Nu = (0.60 + 0.387 Ra^(1/6) / (1 + (0.559/Pr)^(9/16))^(8/27))²
  const S root = S(0.60) + S(0.387) * pow(Ra, S(1) / S(6)) /
                               pow(S(1) + pow(S(0.559) / Pr, S(9) / S(16)), S(8) / S(27));
  return root * root * conductivity_W_mK / diameter_m;
}

/// Convection of a horizontal wire in still air of 25 °C, as a line through Churchill and Chu's
/// values at 20 and 80 K above it; within 2 % of their formula from 10 to 110 K for wires up to 100
/// µm, within 4 % up to 510 µm.
struct StillAir {
  double convection_W_m2K;
  double convection_W_m2K2;
};
inline StillAir still_air(double diameter_m) {
  const double ambient_K = room_K;
  const double low = natural_convection_W_m2K(diameter_m, ambient_K + 20, ambient_K);
  const double high = natural_convection_W_m2K(diameter_m, ambient_K + 80, ambient_K);
  const double slope = (high - low) / 60;
  return {low - 20 * slope, slope};
}

/// A wire as one body: the heat balance of its middle, away from the clamps.
template <class S>
struct ThermalBody {
  S capacity_J_K;  ///< m c
  S latent_m2a_J;  ///< m ΔH of M2A
  S latent_r2a_J;  ///< m ΔH of R2A and A2R; R2M has the difference, so that a cycle releases no net
                   ///< heat
  S loss_W_K;      ///< loss through convection and clamps at the ambient temperature
  S loss_W_K2;     ///< increase of loss_W_K per kelvin above ambient

  constexpr S loss_W(S above_ambient_K) const {
    return (loss_W_K + loss_W_K2 * above_ambient_K) * above_ambient_K;
  }
  constexpr S loss_slope_W_K(S above_ambient_K) const {
    return loss_W_K + S(2) * loss_W_K2 * above_ambient_K;
  }
  /// Heat that the wire takes up per kelvin while it transforms at these rates; never less than
  /// capacity_J_K, as latent heat only adds.
  constexpr S effective_capacity_J_K(const PhaseRates<S>& rates) const {
    const S latent_J_K = -(latent_m2a_J * rates.martensite_1_K) - latent_r2a_J * rates.r_phase_1_K;
    return latent_J_K < S(0) ? capacity_J_K : capacity_J_K + latent_J_K;
  }
};

}  // namespace smaservo
