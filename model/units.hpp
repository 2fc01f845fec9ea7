#pragma once
// Units at the edges: names of columns and keys end in a unit, all values inside are SI.

#include <array>
#include <optional>
#include <span>
#include <string_view>

namespace smaservo {

/// value in SI = factor * value + offset
struct Unit {
  std::string_view suffix;
  double factor;
  double offset = 0;

  /// A value in this unit, in SI.
  constexpr double to_si(double value) const { return factor * value + offset; }
  /// A value in SI, in this unit.
  constexpr double from_si(double value) const { return (value - offset) / factor; }
};

/// All units of one kind; the first one is SI's own. A kind without dimension has the suffix "".
using Kind = std::span<const Unit>;

/// 0 °C in kelvin.
inline constexpr double zero_degC_K = 273.15;
/// 25 degC: the air, where nobody says another temperature, and the reference of cold resistances.
inline constexpr double room_K = 298.15;

namespace kind {

inline constexpr auto number = std::to_array<Unit>({{"", 1}, {"percent", 0.01}});
inline constexpr auto count = std::to_array<Unit>({{"", 1}});
inline constexpr auto time = std::to_array<Unit>({{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}});
inline constexpr auto temperature = std::to_array<Unit>({{"K", 1}, {"degC", 1, zero_degC_K}});
inline constexpr auto temperature_difference = std::to_array<Unit>({{"K", 1}});
inline constexpr auto length = std::to_array<Unit>({{"m", 1}, {"mm", 1e-3}, {"um", 1e-6}});
inline constexpr auto velocity = std::to_array<Unit>({{"m_s", 1}, {"mm_s", 1e-3}, {"um_s", 1e-6}});
inline constexpr auto current = std::to_array<Unit>({{"A", 1}, {"mA", 1e-3}});
inline constexpr auto voltage = std::to_array<Unit>({{"V", 1}, {"mV", 1e-3}});
inline constexpr auto resistance = std::to_array<Unit>({{"ohm", 1}, {"mohm", 1e-3}});
inline constexpr auto force = std::to_array<Unit>({{"N", 1}, {"mN", 1e-3}, {"gf", 9.80665e-3}});
inline constexpr auto stress =
    std::to_array<Unit>({{"Pa", 1}, {"kPa", 1e3}, {"MPa", 1e6}, {"GPa", 1e9}});
inline constexpr auto resistivity =
    std::to_array<Unit>({{"ohm_m", 1}, {"uohm_m", 1e-6}, {"uohm_cm", 1e-8}});
inline constexpr auto resistivity_slope = std::to_array<Unit>({{"ohm_m_K", 1}});
inline constexpr auto resistivity_polynomial = std::to_array<Unit>({{"ohm_m_by_K", 1}});
inline constexpr auto spring_rate = std::to_array<Unit>({{"N_per_m", 1}});
inline constexpr auto resistance_per_length = std::to_array<Unit>({{"ohm_per_m", 1}});
inline constexpr auto per_kelvin = std::to_array<Unit>({{"1_K", 1}});
inline constexpr auto per_stress = std::to_array<Unit>({{"1_Pa", 1}, {"1_GPa", 1e-9}});
inline constexpr auto density = std::to_array<Unit>({{"kg_m3", 1}});
inline constexpr auto specific_heat = std::to_array<Unit>({{"J_kgK", 1}});
inline constexpr auto specific_energy = std::to_array<Unit>({{"J_kg", 1}, {"kJ_kg", 1e3}});
inline constexpr auto specific_power =
    std::to_array<Unit>({{"W_per_kg", 1}, {"W_per_g", 1e3}, {"mW_per_mg", 1e3}});
inline constexpr auto heat_transfer = std::to_array<Unit>({{"W_m2K", 1}});
inline constexpr auto heat_transfer_slope = std::to_array<Unit>({{"W_m2K2", 1}});
inline constexpr auto conductivity = std::to_array<Unit>({{"W_mK", 1}});
inline constexpr auto rate = std::to_array<Unit>({{"1_s", 1}});
inline constexpr auto heating_rate = std::to_array<Unit>({{"K_s", 1}});
inline constexpr auto power = std::to_array<Unit>({{"W", 1}, {"mW", 1e-3}});
inline constexpr auto power_per_kelvin = std::to_array<Unit>({{"W_K", 1}});
inline constexpr auto power_per_ohm = std::to_array<Unit>({{"W_ohm", 1}});
inline constexpr auto power_per_force = std::to_array<Unit>({{"W_N", 1}});
inline constexpr auto kelvin_per_stress = std::to_array<Unit>({{"K_Pa", 1}, {"K_MPa", 1e-6}});
inline constexpr auto kelvin_per_square_stress = std::to_array<Unit>({{"K_Pa2", 1}});
inline constexpr auto resistivity_per_stress = std::to_array<Unit>({{"ohm_m_Pa", 1}});

}  // namespace kind

/// The unit of `name` when it is `base` followed by a suffix of this kind, such as "current_mA"
/// for base "current"; nothing when it is another name.
constexpr std::optional<Unit> unit_of(std::string_view name, std::string_view base, Kind kind) {
  if (!name.starts_with(base)) {
    return std::nullopt;
  }
  std::string_view rest = name.substr(base.size());
  if (!rest.empty()) {
    if (rest.front() != '_') {
      return std::nullopt;
    }
    rest.remove_prefix(1);
  }
  for (const Unit& unit : kind) {
    if (rest == unit.suffix) {
      return unit;
    }
  }
  return std::nullopt;
}

}  // namespace smaservo
