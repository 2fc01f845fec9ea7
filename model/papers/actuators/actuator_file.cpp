#include "model/papers/actuators/actuator_file.hpp"

#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <vector>

#include "model/files/error.hpp"
#include "model/files/input_file.hpp"
#include "model/files/toml/toml_fields.hpp"

namespace smaservo::papers {
namespace {

using Params = DuhemActuator<double>::Params;

constexpr std::string_view strain_laws[] = {"balance", "polynomial"};

/// The keys of a file, and for each slot the member that it fills.
struct Keys {
  std::vector<files::Field> fields;
  std::vector<double*> members;
  std::size_t law;  ///< slot of the strain law

  void add(std::string path, files::FieldType type, Kind kind, double min, double max,
           std::span<double> to) {
    fields.push_back({std::move(path), type, kind, min, max, members.size(), to.size(), {}, ""});
    for (double& member : to) {
      members.push_back(&member);
    }
  }
};

Keys make_keys(Params& p) {
  Keys keys{};
  const auto number = [&](const char* path, Kind kind, double min, double max, double& to) {
    keys.add(path, files::FieldType::number, kind, min, max, std::span(&to, 1));
  };
  const auto list = [&](const char* path, Kind kind, double min, double max, std::span<double> to) {
    keys.add(path, files::FieldType::list, kind, min, max, to);
  };
  number("wire.length", kind::length, 1e-3, 100, p.bias.length_m);
  number("wire.diameter", kind::length, 5e-6, 5e-3, p.bias.diameter_m);
  number("wire.density", kind::density, 1e3, 2e4, p.density_kg_m3);

  auto& heat = p.heat;
  number("heat.ambient", kind::temperature, 200, 400, p.ambient_K);
  number("heat.heating", kind::heat_transfer, 0.1, 1e5, heat.heating_W_m2K);
  number("heat.heating_slope", kind::heat_transfer_slope, -1e3, 1e3, heat.heating_W_m2K2);
  number("heat.cooling", kind::heat_transfer, 0.1, 1e5, heat.cooling_W_m2K);
  number("heat.cooling_step", kind::heat_transfer, -1e5, 1e5, heat.cooling_step_W_m2K);
  number("heat.cooling_centre", kind::temperature, 200, 600, heat.cooling_centre_K);
  number("heat.cooling_width", kind::temperature_difference, 0.1, 200, heat.cooling_width_K);
  number("heat.capacity", kind::specific_heat, 50, 1e4, heat.capacity_J_kgK);
  number("heat.capacity_step", kind::specific_heat, -1e4, 1e4, heat.capacity_step_J_kgK);
  number("heat.capacity_centre", kind::temperature, 200, 600, heat.capacity_centre_K);
  number("heat.capacity_width", kind::temperature_difference, 0.5, 200, heat.capacity_width_K);

  auto& kinetics = p.kinetics;
  number("kinetics.m2a.centre", kind::temperature, 150, 600, kinetics.m2a.centre_K);
  number("kinetics.m2a.deviation", kind::temperature_difference, 0.1, 100,
         kinetics.m2a.deviation_K);
  number("kinetics.a2m.centre", kind::temperature, 150, 600, kinetics.a2m.centre_K);
  number("kinetics.a2m.deviation", kind::temperature_difference, 0.1, 100,
         kinetics.a2m.deviation_K);

  auto& bias = p.bias;
  number("spring.rate", kind::spring_rate, 1e-3, 1e6, bias.spring_N_m);
  number("spring.deformation", kind::length, 1e-6, 10, bias.deformation_m);
  number("strain.austenite", kind::stress, 1e6, 1e12, bias.austenite_Pa);
  number("strain.twinned", kind::stress, 1e6, 1e12, bias.twinned_Pa);
  number("strain.part_twinned", kind::stress, 1e4, 1e12, bias.part_twinned_Pa);
  number("strain.detwinned", kind::stress, 1e6, 1e12, bias.detwinned_Pa);
  number("strain.yield", kind::number, 1e-5, 0.3, bias.yield_strain);
  number("strain.detwinned_from", kind::number, 1e-5, 0.3, bias.detwinned_strain);
  list("strain.smooth", kind::number, -1, 1, bias.smooth);

  auto& rho = p.resistivity;
  number("resistivity.austenite", kind::resistivity, 1e-8, 1e-4, rho.austenite_ohm_m);
  number("resistivity.austenite_cold", kind::resistivity, 0, 1e-4, rho.austenite_cold_ohm_m);
  number("resistivity.austenite_decay", kind::per_kelvin, 0, 10, rho.austenite_decay_1_K);
  number("resistivity.step", kind::resistivity, -1e-4, 1e-4, rho.step_ohm_m);
  number("resistivity.step_slope", kind::resistivity_slope, -1e-6, 1e-6, rho.step_ohm_m_K);
  number("resistivity.step_centre", kind::temperature, 200, 600, rho.step_centre_K);
  number("resistivity.step_width", kind::temperature_difference, 0.1, 200, rho.step_width_K);
  list("resistivity.martensite", kind::resistivity_polynomial, -1e-4, 1e-4, rho.martensite_ohm_m_K);
  number("resistivity.lowest", kind::temperature, 200, 600, rho.lowest_K);
  number("resistivity.highest", kind::temperature, 200, 600, rho.highest_K);
  keys.law = keys.members.size();
  keys.fields.push_back(
      {"strain.law", files::FieldType::choice, kind::count, 0, 0, keys.law, 1, strain_laws, ""});
  return keys;
}

/// Checks that the range of a single value cannot make.
class Check {
 public:
  Check(const Params& p, std::string origin) : p_(p), origin_(std::move(origin)) {}

  void operator()() const {
    const auto& k = p_.kinetics;
    if (!(k.a2m.centre_K < k.m2a.centre_K)) {
      refuse("kinetics.m2a.centre", fmt::format("must lie above that of a2m, is {:.4g} K below it",
                                                k.a2m.centre_K - k.m2a.centre_K));
    }
    const auto& b = p_.bias;
    if (!(b.yield_strain < b.detwinned_strain)) {
      refuse("strain.detwinned_from", fmt::format("must be above strain.yield, {:.4g}, is {:.4g}",
                                                  b.yield_strain, b.detwinned_strain));
    }
    if (!std::isfinite(b.prestrain())) {
      refuse("spring", "pulls more than the wire can hold: 16 k Δ must not exceed π d_0² E_a");
    }
    check_heat();
    check_resistivity();
  }

 private:
  [[noreturn]] void refuse(const std::string& key, const std::string& reason) const {
    throw files::ConfigError(fmt::format("{}: {}: {}", origin_, key, reason));
  }

  void check_heat() const {
    const auto& h = p_.heat;
    if (!(std::abs(h.capacity_step_J_kgK) < h.capacity_J_kgK)) {
      refuse("heat.capacity_step",
             fmt::format("must be smaller than heat.capacity, {:.4g}, is {:.4g}", h.capacity_J_kgK,
                         h.capacity_step_J_kgK));
    }
    if (!(std::abs(h.cooling_step_W_m2K) < h.cooling_W_m2K)) {
      refuse("heat.cooling_step",
             fmt::format("must be smaller than heat.cooling, {:.4g}, is {:.4g}", h.cooling_W_m2K,
                         h.cooling_step_W_m2K));
    }
    for (const double T : {p_.resistivity.lowest_K, p_.resistivity.highest_K}) {
      const double W_m2K = h.convection_W_m2K(T, Heading::heating);
      if (!(W_m2K > 0)) {
        refuse("heat.heating_slope",
               fmt::format("convection must be positive, is {:.4g} W_m2K at {:.4g} K", W_m2K, T));
      }
    }
  }

  void check_resistivity() const {
    const auto& rho = p_.resistivity;
    if (!(rho.lowest_K < rho.highest_K)) {
      refuse("resistivity.highest",
             fmt::format("must lie above resistivity.lowest, {:.4g} K, is {:.4g} K", rho.lowest_K,
                         rho.highest_K));
    }
    for (int i = 0; i <= 100; ++i) {
      const double T = rho.lowest_K + (rho.highest_K - rho.lowest_K) * i / 100;
      const double ohm_m = rho.martensite(T, p_.ambient_K);
      if (!(ohm_m > 0)) {
        refuse("resistivity.martensite",
               fmt::format("must be positive from lowest to highest, is {:.4g} ohm_m at {:.4g} K",
                           ohm_m, T));
      }
    }
  }

  const Params& p_;
  std::string origin_;
};

}  // namespace

Params load_actuator(const std::string& name_or_path) {
  if (name_or_path.ends_with(".toml")) {
    return parse_actuator(files::whole_file(name_or_path), name_or_path);
  }
  std::vector<std::string_view> names;
  for (const ActuatorPreset& preset : actuator_presets()) {
    if (preset.name == name_or_path) {
      return parse_actuator(preset.text, fmt::format("preset {}", preset.name));
    }
    names.push_back(preset.name);
  }
  throw files::ConfigError(
      fmt::format("{}: no such actuator; a file's name ends in .toml, the presets are: {}",
                  name_or_path, fmt::join(names, ", ")));
}

Params parse_actuator(std::string_view text, const std::string& origin) {
  Params p{};
  const Keys keys = make_keys(p);
  const files::Entries entries =
      files::read_fields(keys.fields, files::parse_toml(text, origin), origin);
  for (const files::Field& field : keys.fields) {
    if (!entries.contains(field.slot)) {
      throw files::ConfigError(fmt::format("{}: {}: is missing", origin, field.path));
    }
  }
  for (std::size_t slot = 0; slot < keys.members.size(); ++slot) {
    *keys.members[slot] = entries.at(slot).number;
  }
  p.strain_law = entries.at(keys.law).number == 0 ? StrainLaw::balance : StrainLaw::polynomial;
  Check(p, origin)();
  return p;
}

}  // namespace smaservo::papers
