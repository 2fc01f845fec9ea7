#include "host-sim/campaign/kinds/drawn_units.hpp"

#include <algorithm>
#include <string>

namespace smaservo::campaign {
namespace {

const Wire<double>& preset() {
  static const Wire<double> wire = files::load_wire(std::string(files::default_wire)).wire;
  return wire;
}

double shift_K(const Surface<double>& drawn, const Surface<double>& preset) {
  return drawn.start_K[0] - preset.start_K[0];
}

}  // namespace

bench::WireUnit nominal_unit(hal::Family family) {
  return {family, 0, files::load_wire(std::string(files::default_wire)), 0.5, {}};
}

std::vector<Column> with_unit_columns(const std::vector<Column>& results) {
  std::vector<Column> all{{"seed", true},
                          {"family", true, true},
                          {"length_ratio", true},
                          {"diameter_ratio", true},
                          {"m2a_shift_K", true},
                          {"a2m_shift_K", true},
                          {"a2r_shift_K", true},
                          {"martensite_strain_ratio", true},
                          {"martensite_modulus_ratio", true},
                          {"martensite_resistivity_ratio", true},
                          {"austenite_resistivity_ratio", true},
                          {"latent_heat_ratio", true},
                          {"specific_heat_ratio", true},
                          {"clamp_conductivity_ratio", true},
                          {"scatter_K", true}};
  all.insert(all.end(), results.begin(), results.end());
  return all;
}

Row unit_cells(const bench::WireUnit& unit, std::uint64_t seed) {
  const Wire<double>& is = unit.wire.wire;
  const Wire<double>& was = preset();
  const auto& m = is.material;
  const auto& n = was.material;
  return {seed,
          std::string(hal::family_name(unit.family)),
          is.geometry.length_m / was.geometry.length_m,
          is.geometry.diameter_m / was.geometry.diameter_m,
          shift_K(is.kinetics.m2a, was.kinetics.m2a),
          shift_K(first_surface(is.kinetics.a2m_a2r), first_surface(was.kinetics.a2m_a2r)),
          shift_K(second_surface(is.kinetics.a2m_a2r), second_surface(was.kinetics.a2m_a2r)),
          m.martensite.strain / n.martensite.strain,
          m.martensite.modulus_Pa / n.martensite.modulus_Pa,
          m.martensite.resistivity_ohm_m / n.martensite.resistivity_ohm_m,
          m.austenite.resistivity_ohm_m / n.austenite.resistivity_ohm_m,
          is.heat.latent_m2a_J_kg / was.heat.latent_m2a_J_kg,
          is.heat.specific_heat_J_kgK / was.heat.specific_heat_J_kgK,
          is.heat.clamp_conductivity_W_mK / was.heat.clamp_conductivity_W_mK,
          unit.scatter_K};
}

std::vector<hal::Family> families_of(KindTable& table) {
  if (!table.keys().has("families")) {
    return {hal::tuning_families.begin(), hal::tuning_families.end()};
  }
  std::vector<hal::Family> families;
  for (const std::string& name : table.keys().texts("families")) {
    const auto* const found = std::ranges::find(hal::families, name, hal::family_name);
    if (found == hal::families.end()) {
      table.keys().fail("families",
                        "must be some of: ihyp, sublayers, free-energy, smooth-hardening");
    }
    families.push_back(*found);
  }
  return families;
}

}  // namespace smaservo::campaign
