#include "model/papers/actuators/actuator_file.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <set>
#include <sstream>
#include <toml++/toml.h>
#include <vector>

#include "model/units.hpp"

namespace smaservo {
namespace {

using Params = DuhemActuator<double>::Params;

/// One key of a file and where its numbers go.
struct Field {
  std::string path;  ///< table and name without unit
  Kind kind;
  double low, high;  ///< SI, inclusive, of every number
  std::span<double> to;
};

constexpr std::string_view law_key = "strain.law";

std::vector<Field> make_fields(Params& p) {
  std::vector<Field> fields;
  const auto number = [&](const char* path, Kind kind, double low, double high, double& to) {
    fields.push_back({path, kind, low, high, std::span(&to, 1)});
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
  fields.push_back({"strain.smooth", kind::number, -1, 1, bias.smooth});

  auto& rho = p.resistivity;
  number("resistivity.austenite", kind::resistivity, 1e-8, 1e-4, rho.austenite_ohm_m);
  number("resistivity.austenite_cold", kind::resistivity, 0, 1e-4, rho.austenite_cold_ohm_m);
  number("resistivity.austenite_decay", kind::per_kelvin, 0, 10, rho.austenite_decay_1_K);
  number("resistivity.step", kind::resistivity, -1e-4, 1e-4, rho.step_ohm_m);
  number("resistivity.step_slope", kind::resistivity_slope, -1e-6, 1e-6, rho.step_ohm_m_K);
  number("resistivity.step_centre", kind::temperature, 200, 600, rho.step_centre_K);
  number("resistivity.step_width", kind::temperature_difference, 0.1, 200, rho.step_width_K);
  fields.push_back({"resistivity.martensite", kind::resistivity_polynomial, -1e-4, 1e-4,
                    rho.martensite_ohm_m_K});
  number("resistivity.lowest", kind::temperature, 200, 600, rho.lowest_K);
  number("resistivity.highest", kind::temperature, 200, 600, rho.highest_K);
  return fields;
}

std::string table_of(const Field& field) {
  return field.path.substr(0, field.path.rfind('.'));
}
std::string name_of(const Field& field) {
  return field.path.substr(field.path.rfind('.') + 1);
}

std::string written(const toml::node& node) {
  std::ostringstream out;
  node.visit([&](const auto& value) { out << value; });
  return out.str();
}

class Reader {
 public:
  explicit Reader(std::string origin) : origin_(std::move(origin)), fields_(make_fields(p_)) {}

  Params read(const toml::table& table) {
    read_table(table, "");
    for (const Field& field : fields_) {
      require(field.path);
    }
    require(std::string(law_key));
    check();
    return p_;
  }

 private:
  [[noreturn]] void fail(const std::string& key, const toml::node& node,
                         const std::string& reason) const {
    throw ActuatorError(fmt::format("{}:{}: {} = {}: {}", origin_, node.source().begin.line, key,
                                    written(node), reason));
  }
  [[noreturn]] void refuse(const std::string& key, const std::string& reason) const {
    throw ActuatorError(fmt::format("{}: {}: {}", origin_, key, reason));
  }

  void require(const std::string& path) const {
    if (!given_.contains(path)) {
      refuse(path, "is missing");
    }
  }

  void read_table(const toml::table& table, const std::string& path) {
    for (const auto& [key, node] : table) {
      const std::string name(key.str());
      const std::string full = path.empty() ? name : path + "." + name;
      if (const toml::table* inner = node.as_table()) {
        read_table(*inner, full);
      } else if (full == law_key) {
        read_law(node);
      } else {
        read_value(node, path, name);
      }
    }
  }

  void read_law(const toml::node& node) {
    const auto word = node.value<std::string>();
    if (word != "balance" && word != "polynomial") {
      fail(std::string(law_key), node, "must be one of: balance, polynomial");
    }
    p_.strain_law = word == "balance" ? StrainLaw::balance : StrainLaw::polynomial;
    given_.insert(std::string(law_key));
  }

  void read_value(const toml::node& node, const std::string& path, const std::string& name) {
    const std::string full = path.empty() ? name : path + "." + name;
    for (const Field& field : fields_) {
      if (path != table_of(field)) {
        continue;
      }
      if (const auto unit = unit_of(name, name_of(field), field.kind)) {
        if (!given_.insert(field.path).second) {
          fail(full, node, "is given twice");
        }
        read_numbers(field, *unit, node, full);
        return;
      }
    }
    fail(full, node, unknown(path, name));
  }

  void read_numbers(const Field& field, const Unit& unit, const toml::node& node,
                    const std::string& full) const {
    if (field.to.size() == 1) {
      field.to[0] = number(field, unit, node, full, node);
      return;
    }
    const toml::array* list = node.as_array();
    if (list == nullptr || list->size() != field.to.size()) {
      fail(full, node, fmt::format("must be a list of {} numbers", field.to.size()));
    }
    for (std::size_t i = 0; i < field.to.size(); ++i) {
      field.to[i] = number(field, unit, *list->get(i), full, node);
    }
  }

  double number(const Field& field, const Unit& unit, const toml::node& item,
                const std::string& full, const toml::node& node) const {
    const auto value = item.is_number() ? item.value<double>() : std::nullopt;
    if (!value || !std::isfinite(*value)) {
      fail(full, node, "must be a finite number");
    }
    const double si = unit.to_si(*value);
    if (!(si >= field.low && si <= field.high)) {
      fail(full, node,
           fmt::format("must be between {:.6g} and {:.6g}{}{}, is {:.6g}", unit.from_si(field.low),
                       unit.from_si(field.high), unit.suffix.empty() ? "" : " ", unit.suffix,
                       *value));
    }
    return si;
  }

  std::string unknown(const std::string& path, const std::string& name) const {
    std::vector<std::string> there;
    const Field* meant = nullptr;
    for (const Field& field : fields_) {
      if (path != table_of(field)) {
        continue;
      }
      there.push_back(name_of(field));
      const bool longest = meant == nullptr || meant->path.size() < field.path.size();
      if ((name + "_").starts_with(there.back() + "_") && longest) {
        meant = &field;
      }
    }
    if (meant != nullptr) {
      std::vector<std::string> keys;
      for (const Unit& unit : meant->kind) {
        keys.push_back(
            fmt::format("{}{}{}", name_of(*meant), unit.suffix.empty() ? "" : "_", unit.suffix));
      }
      return fmt::format("unknown key or unit; allowed: {}", fmt::join(keys, ", "));
    }
    return there.empty() ? "unknown table"
                         : fmt::format("unknown key; [{}] has: {}", path, fmt::join(there, ", "));
  }

  /// What single ranges cannot see.
  void check() const {
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

  std::string origin_;
  Params p_{};
  std::vector<Field> fields_;
  std::set<std::string> given_;
};

std::string read_text(const std::string& file) {
  const std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  if (!in || !(text << in.rdbuf())) {
    throw ActuatorError(fmt::format("{}: cannot be read", file));
  }
  return text.str();
}

}  // namespace

Params load_actuator(const std::string& name_or_path) {
  if (name_or_path.ends_with(".toml")) {
    return parse_actuator(read_text(name_or_path), name_or_path);
  }
  std::vector<std::string_view> names;
  for (const ActuatorPreset& preset : actuator_presets()) {
    if (preset.name == name_or_path) {
      return parse_actuator(preset.text, fmt::format("preset {}", preset.name));
    }
    names.push_back(preset.name);
  }
  throw ActuatorError(
      fmt::format("{}: no such actuator; a file's name ends in .toml, the presets are: {}",
                  name_or_path, fmt::join(names, ", ")));
}

Params parse_actuator(std::string_view text, const std::string& origin) {
  try {
    return Reader(origin).read(toml::parse(text, origin));
  } catch (const toml::parse_error& error) {
    throw ActuatorError(fmt::format("{}:{}:{}: {}", origin, error.source().begin.line,
                                    error.source().begin.column, error.description()));
  }
}

}  // namespace smaservo
