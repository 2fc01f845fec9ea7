#pragma once
// Air that a fan moves across a wire.

#include <algorithm>
#include <cmath>

#include "model/wire/heat.hpp"

namespace smaservo::choose {

/// Nusselt number of a cylinder in a flow across it, after Churchill and Bernstein (1977). Within
/// 10 % of what Collis and Williams (1959) measured on thin wires, Re 0.3 to 140.
inline double cross_flow_nusselt(double reynolds, double prandtl) {
  return 0.3 + 0.62 * std::sqrt(reynolds) * std::cbrt(prandtl) /
                   std::pow(1 + std::pow(0.4 / prandtl, 2.0 / 3), 0.25) *
                   std::pow(1 + std::pow(reynolds / 282'000, 0.625), 0.8);
}

/// Heat transfer coefficient of a wire in air that flows across it, W/(m² K), with the properties
/// of air at the film temperature and 101325 Pa. diameter_m and temperatures as for
/// natural_convection_W_m2K(); speed_m_s 0 to 50.
inline double cross_flow_W_m2K(double diameter_m, double speed_m_s, double temperature_K,
                               double ambient_K) {
  const double film_K = 0.5 * (temperature_K + ambient_K);
  // Without buoyancy Churchill and Chu's formula is 0.36 k/d.
  const double conductivity_W_mK = natural_convection_W_m2K(1.0, film_K, film_K) / 0.36;
  constexpr double prandtl = 0.71;  // 0.69 to 0.72 between 230 and 600 K
  const double density_kg_m3 = 101325 / (287.05 * film_K);
  const double viscosity_m2_s = prandtl * conductivity_W_mK / (density_kg_m3 * 1006);
  return cross_flow_nusselt(speed_m_s * diameter_m / viscosity_m2_s, prandtl) * conductivity_W_mK /
         diameter_m;
}

/// By which factor such air takes more heat from the wire than still air; at least 1.
inline double fan_draught(double diameter_m, double speed_m_s, double temperature_K,
                          double ambient_K) {
  return std::max(1.0, cross_flow_W_m2K(diameter_m, speed_m_s, temperature_K, ambient_K) /
                           natural_convection_W_m2K(diameter_m, temperature_K, ambient_K));
}

}  // namespace smaservo::choose
