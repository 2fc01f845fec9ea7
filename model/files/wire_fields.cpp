#include "model/files/wire_fields.hpp"

#include <cmath>
#include <fmt/format.h>

#include "model/wire/plant.hpp"

namespace smaservo {
namespace {

constexpr std::string_view memories[] = {"return-point", "plain"};
constexpr std::string_view mixtures[] = {"series", "parallel"};

WireField number(std::string path, Kind kind, double low, double high, bool required,
                 std::string meaning) {
  return {std::move(path), WireFieldType::number, kind, low, high, 1, {},
          required,        std::move(meaning)};
}

WireField polynomial(std::string path, Kind kind, double low, double high, std::size_t coefficients,
                     bool required, std::string meaning) {
  return {std::move(path), WireFieldType::polynomial, kind, low, high, coefficients, {},
          required,        std::move(meaning)};
}

WireField choice(std::string path, std::span<const std::string_view> choices, std::string meaning) {
  return {std::move(path), WireFieldType::choice, {}, 0, 0, 0, choices, false, std::move(meaning)};
}

std::vector<WireField> make_fields() {
  std::vector<WireField> f{
      number("wire.length", kind::length, 1e-3, 100, true, "between the clamps"),
      number("wire.diameter", kind::length, 5e-6, 5e-3, true, "of the bare wire"),
      number("wire.nominal_stroke", kind::number, 1e-3, 0.2, false,
             "strain that errors are related to; 0.04"),
      number("wire.resistance", kind::resistance_per_length, 1e-3, 1e5, false,
             "of the cold wire without load, by its length between the clamps; scales all "
             "resistivities to it"),
      number("limits.current", kind::current, 1e-4, 100, true, "the maker's, in still air"),
      number("limits.load", kind::force, 1e-4, 1e4, true, "the maker's"),
      number("limits.temperature", kind::temperature, 300, 700, true, "of the wire"),
      choice("kinetics.memory", memories, "how inner loops behave; return-point"),
      number("kinetics.smallest_reversal", kind::temperature_difference, 0, 5, false,
             "a reversal below it does not count; 0.5 with return-point memory, 0 without")};
  const auto process = [&](const std::string& name, bool required, const std::string& meaning) {
    const std::string path = "kinetics." + name;
    f.push_back(
        polynomial(path + ".start", kind::temperature, 150, 600, 3, required, meaning + ": T_s"));
    f.push_back(
        polynomial(path + ".finish", kind::temperature, 150, 600, 3, required, meaning + ": T_f"));
    f.push_back(polynomial(path + ".curvature", kind::number, 1e-3, 30, 2, required,
                           meaning + ": curvature"));
    f.push_back(polynomial(path + ".turning", kind::number, 0.05, 0.95, 2, required,
                           meaning + ": fraction at the turning point"));
  };
  process("m2a", true, "martensite to austenite");
  process("a2m", true, "austenite to martensite");
  process("a2r", true, "austenite to R-phase");
  process("r2a", false, "R-phase to austenite; as m2a");
  process("r2m", false, "R-phase to martensite; as a2m");
  f.push_back(
      number("material.reference", kind::temperature, 200, 400, true, "of the resistivities"));
  f.push_back(choice("material.mixture", mixtures, "of the phases' resistivities; series"));
  const auto phase = [&](const std::string& name) {
    const std::string path = "material." + name;
    f.push_back(number(path + ".strain", kind::number, -0.05, 0.2, true, "without stress"));
    f.push_back(number(path + ".modulus", kind::stress, 1e9, 1e12, true, "Young's modulus"));
    f.push_back(number(path + ".resistivity", kind::resistivity, 1e-8, 1e-4, true,
                       "at the reference temperature, without stress"));
    f.push_back(number(path + ".resistivity_temperature", kind::per_kelvin, -0.01, 0.01, true,
                       "its relative change per kelvin"));
    f.push_back(number(path + ".resistivity_stress", kind::per_stress, -1e-8, 1e-8, false,
                       "its relative change per stress; 0"));
  };
  phase("martensite");
  phase("r_phase");
  phase("austenite");
  for (WireField& field : std::vector<WireField>{
           number("heat.density", kind::density, 1e3, 2e4, true, "of the alloy"),
           number("heat.specific_heat", kind::specific_heat, 50, 5000, true,
                  "without transformation"),
           number("heat.latent_m2a", kind::specific_energy, 0, 1e5, true,
                  "martensite to austenite"),
           number("heat.latent_r2a", kind::specific_energy, 0, 1e5, true,
                  "R-phase to austenite; not above latent_m2a, R2M takes the difference"),
           number("heat.convection", kind::heat_transfer, 0.1, 1e5, false,
                  "h at ambient temperature; still air"),
           number("heat.convection_slope", kind::heat_transfer_slope, 0, 1e3, false,
                  "what h gains per kelvin above it; still air"),
           number("heat.clamp_conductivity", kind::conductivity, 0, 500, true,
                  "of the wire, towards its cold clamps; 0 without"),
           number("accuracy.strain", kind::number, 1e-5, 0.1, false,
                  "root mean square of what the model, from power and load alone, is off; 0.002"),
           number("accuracy.resistance", kind::number, 1e-5, 0.1, false,
                  "and of the resistance at a given strain, relative; 0.004")}) {
    f.push_back(std::move(field));
  }
  return f;
}

class Builder {
 public:
  Builder(const WireEntries& entries,
          const std::function<void(std::string_view, const std::string&)>& fail)
      : entries_(entries), fail_(fail) {}

  Wire<double> build() {
    Wire<double> w{};
    w.geometry = {number("wire.length"), number("wire.diameter")};
    w.nominal_stroke = number("wire.nominal_stroke", 0.04);
    w.limits = {number("limits.current"), w.stress_Pa(number("limits.load")),
                number("limits.temperature")};
    kinetics(w);
    heat(w);
    material(w);
    // The defaults are those of a wire that nobody has calibrated.
    w.accuracy = {number("accuracy.strain", 0.002), number("accuracy.resistance", 0.004)};
    return w;
  }

 private:
  const WireEntry* find(std::string_view path) const {
    const auto it = entries_.find(path);
    return it == entries_.end() ? nullptr : &it->second;
  }
  double number(std::string_view path) const {
    const WireEntry* entry = find(path);
    if (entry == nullptr) {
      fail_(path, "is missing");
    }
    return entry->numbers.front();
  }
  double number(std::string_view path, double otherwise) const {
    return find(path) == nullptr ? otherwise : number(path);
  }
  std::string_view word(std::string_view path, std::string_view otherwise) const {
    const WireEntry* entry = find(path);
    return entry == nullptr ? otherwise : entry->word;
  }

  bool has_process(const std::string& name) const {
    int given = 0;
    for (const char* part : {".start", ".finish", ".curvature", ".turning"}) {
      given += find("kinetics." + name + part) != nullptr ? 1 : 0;
    }
    if (given != 0 && given != 4) {
      fail_("kinetics." + name, "needs start, finish, curvature and turning, all four");
    }
    return given == 4;
  }

  template <std::size_t n>
  void coefficients(const std::string& path, double (&to)[n]) const {
    const WireEntry* entry = find(path);
    if (entry == nullptr) {
      fail_(path, "is missing");
    }
    for (std::size_t i = 0; i < n; ++i) {
      to[i] = i < entry->numbers.size() ? entry->numbers[i] : 0.0;
    }
  }

  Surface<double> surface(const std::string& name, bool heating, double highest_stress_Pa) const {
    Surface<double> s{};
    const std::string path = "kinetics." + name;
    coefficients(path + ".start", s.start_K);
    coefficients(path + ".finish", s.finish_K);
    coefficients(path + ".curvature", s.curvature);
    coefficients(path + ".turning", s.turning);
    for (int i = 0; i <= 20; ++i) {
      const double stress_Pa = highest_stress_Pa * i / 20;
      const Isobar<double> at = isobar(s, stress_Pa);
      const double finish_K = at.start_K + 1 / at.per_K;
      const double span_K = 1 / at.per_K;
      const std::string where = fmt::format(" at {:.4g} MPa", stress_Pa / 1e6);
      for (const double T : {at.start_K, finish_K}) {
        if (!(T >= 150 && T <= 600)) {
          fail_(path,
                fmt::format("start and finish must lie between 150 and 600 K, one is {:.4g} K{}", T,
                            where));
        }
      }
      if (!(heating ? span_K >= 1 : span_K <= -1)) {
        fail_(path, fmt::format("finish must lie at least 1 K {} start, is {:.4g} K{}",
                                heating ? "above" : "below", heating ? span_K : -span_K, where));
      }
      if (!(at.shape.curvature >= 1e-3 && at.shape.curvature <= 30)) {
        fail_(path + ".curvature",
              fmt::format("must be between 0.001 and 30, is {:.4g}{}", at.shape.curvature, where));
      }
      if (!(at.shape.turning >= 0.05 && at.shape.turning <= 0.95)) {
        fail_(path + ".turning",
              fmt::format("must be between 0.05 and 0.95, is {:.4g}{}", at.shape.turning, where));
      }
    }
    return s;
  }

  void kinetics(Wire<double>& w) const {
    auto& k = w.kinetics;
    const double stress_Pa = w.limits.stress_Pa;
    k.memory =
        word("kinetics.memory", "return-point") == "plain" ? Memory::plain : Memory::return_point;
    k.smallest_reversal_K =
        number("kinetics.smallest_reversal", k.memory == Memory::plain ? 0.0 : 0.5);
    k.m2a = surface("m2a", true, stress_Pa);
    k.a2m_a2r = pair_surfaces(surface("a2m", false, stress_Pa), surface("a2r", false, stress_Pa));
    k.separate_r2a = has_process("r2a");
    k.separate_r2m = has_process("r2m");
    if (k.separate_r2a) {
      k.r2a = surface("r2a", true, stress_Pa);
    }
    if (k.separate_r2m) {
      k.r2m = surface("r2m", false, stress_Pa);
    }
  }

  Phase<double> phase(const std::string& name, double scale) const {
    const std::string path = "material." + name;
    const double rho = scale * number(path + ".resistivity");
    return {number(path + ".strain"), number(path + ".modulus"), rho,
            rho * number(path + ".resistivity_temperature"),
            rho * number(path + ".resistivity_stress", 0.0)};
  }

  /// A given resistance per length scales all resistivities; their ratios stay.
  void material(Wire<double>& w) const {
    mix(w, 1);
    if (find("wire.resistance") != nullptr) {
      const double ohm = number("wire.resistance") * w.geometry.length_m;
      mix(w, ohm / cold_resistance_ohm(w));
    }
  }

  void mix(Wire<double>& w, double scale) const {
    w.material = {
        phase("martensite", scale), phase("r_phase", scale), phase("austenite", scale),
        number("material.reference"),
        word("material.mixture", "series") == "parallel" ? Mixture::parallel : Mixture::series};
  }

  void heat(Wire<double>& w) const {
    const StillAir air = still_air(w.geometry.diameter_m);
    w.heat = {number("heat.density"),
              number("heat.specific_heat"),
              number("heat.latent_m2a"),
              number("heat.latent_r2a"),
              number("heat.convection", air.convection_W_m2K),
              number("heat.convection_slope", air.convection_W_m2K2),
              number("heat.clamp_conductivity")};
    if (w.heat.latent_r2a_J_kg > w.heat.latent_m2a_J_kg) {
      fail_("heat.latent_r2a", "must not be above heat.latent_m2a: a closed cycle would gain heat");
    }
  }

  const WireEntries& entries_;
  const std::function<void(std::string_view, const std::string&)>& fail_;
};

}  // namespace

const std::vector<WireField>& wire_fields() {
  static const std::vector<WireField> fields = make_fields();
  return fields;
}

std::vector<PolynomialUnit> polynomial_units(const WireField& field) {
  std::vector<PolynomialUnit> units;
  for (const Unit& value : field.kind) {
    for (const Unit& stress : {kind::stress[0], kind::stress[2]}) {
      const std::string prefix = value.suffix.empty() ? "" : std::string(value.suffix) + "_";
      units.push_back({prefix + "by_" + std::string(stress.suffix), value, stress.factor});
    }
  }
  return units;
}

Wire<double> build_wire(const WireEntries& entries,
                        const std::function<void(std::string_view, const std::string&)>& fail) {
  return Builder(entries, fail).build();
}

WireEntries describe_wire(const Wire<double>& w) {
  WireEntries e;
  const auto number = [&](const std::string& path, double value) { e[path].numbers = {value}; };
  number("wire.length", w.geometry.length_m);
  number("wire.diameter", w.geometry.diameter_m);
  number("wire.nominal_stroke", w.nominal_stroke);
  number("limits.current", w.limits.current_A);
  number("limits.load", w.limits.stress_Pa * w.geometry.area_m2());
  number("limits.temperature", w.limits.temperature_K);
  e["kinetics.memory"].word = w.kinetics.memory == Memory::plain ? "plain" : "return-point";
  number("kinetics.smallest_reversal", w.kinetics.smallest_reversal_K);
  const auto process = [&](const std::string& name, const Surface<double>& s) {
    const std::string path = "kinetics." + name;
    e[path + ".start"].numbers = {s.start_K[0], s.start_K[1], s.start_K[2]};
    e[path + ".finish"].numbers = {s.finish_K[0], s.finish_K[1], s.finish_K[2]};
    e[path + ".curvature"].numbers = {s.curvature[0], s.curvature[1]};
    e[path + ".turning"].numbers = {s.turning[0], s.turning[1]};
  };
  process("m2a", w.kinetics.m2a);
  process("a2m", first_surface(w.kinetics.a2m_a2r));
  process("a2r", second_surface(w.kinetics.a2m_a2r));
  if (w.kinetics.separate_r2a) {
    process("r2a", w.kinetics.r2a);
  }
  if (w.kinetics.separate_r2m) {
    process("r2m", w.kinetics.r2m);
  }
  number("material.reference", w.material.reference_K);
  e["material.mixture"].word = w.material.mixture == Mixture::parallel ? "parallel" : "series";
  const auto phase = [&](const std::string& name, const Phase<double>& p) {
    const std::string path = "material." + name;
    number(path + ".strain", p.strain);
    number(path + ".modulus", p.modulus_Pa);
    number(path + ".resistivity", p.resistivity_ohm_m);
    number(path + ".resistivity_temperature", p.resistivity_ohm_m_K / p.resistivity_ohm_m);
    number(path + ".resistivity_stress", p.resistivity_ohm_m_Pa / p.resistivity_ohm_m);
  };
  phase("martensite", w.material.martensite);
  phase("r_phase", w.material.r_phase);
  phase("austenite", w.material.austenite);
  number("heat.density", w.heat.density_kg_m3);
  number("heat.specific_heat", w.heat.specific_heat_J_kgK);
  number("heat.latent_m2a", w.heat.latent_m2a_J_kg);
  number("heat.latent_r2a", w.heat.latent_r2a_J_kg);
  number("heat.convection", w.heat.convection_W_m2K);
  number("heat.convection_slope", w.heat.convection_W_m2K2);
  number("heat.clamp_conductivity", w.heat.clamp_conductivity_W_mK);
  number("accuracy.strain", w.accuracy.strain);
  number("accuracy.resistance", w.accuracy.resistance);
  return e;
}

}  // namespace smaservo
