#include "model/files/wire/wire_fields.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "model/wire/plant.hpp"
#include "model/wire/wire_check.hpp"

namespace smaservo::files {
namespace {

using Row = WireParameter<double>;
constexpr auto& rows = wire_parameters<double>;
constexpr std::size_t resistance_slot = wire_parameter_count;

/// The row's path without its unit.
std::string bare_path(const Row& row) {
  std::string_view path = row.path.text();
  const std::string_view unit = row.kind.front().suffix;
  path.remove_suffix(unit.empty() ? 0 : unit.size() + 1);
  return std::string(path);
}

consteval std::size_t row_of(std::string_view path) {
  std::size_t i = 0;
  while (rows[i].path.text() != path) {
    ++i;
  }
  return i;
}
constexpr std::size_t stress_slot = row_of("wire.limits.stress_Pa");

Field number_field(std::string path, Kind kind, double min, double max, std::size_t slot,
                   std::string meaning) {
  return {std::move(path), FieldType::number, kind, min, max, slot, 1, {}, std::move(meaning)};
}

/// Adds the notations that only files know, before the row that they replace.
void add_notation(std::vector<Field>& fields, const Row& row, std::size_t slot) {
  const std::string path = bare_path(row);
  const std::string meaning(row.meaning);
  if (row.coefficients > 1) {
    fields.push_back({path.substr(0, path.size() - 2),  // path without "_0"
                      FieldType::polynomial,
                      row.kind,
                      row.min,
                      row.max,
                      slot,
                      row.coefficients,
                      {},
                      meaning});
  }
  if (slot == stress_slot) {
    fields.push_back(
        number_field("wire.limits.load", kind::force, 1e-4, 1e4, slot, "the maker's maximum load"));
  }
  if (path.ends_with(".resistivity_temperature")) {
    fields.push_back(number_field(path, kind::per_kelvin, -0.01, 0.01, slot,
                                  "change of the resistivity per kelvin, relative"));
  }
  if (path.ends_with(".resistivity_stress")) {
    fields.push_back(number_field(path, kind::per_stress, -1e-8, 1e-8, slot,
                                  "change of the resistivity by stress, relative"));
  }
}

std::vector<Field> make_wire_fields() {
  std::vector<Field> fields;
  for (std::size_t slot = 0; slot < rows.size(); ++slot) {
    const Row& row = rows[slot];
    add_notation(fields, row, slot);
    fields.push_back({bare_path(row), field_type(row.type), row.kind, row.min, row.max, slot, 1,
                      row.choices, std::string(row.meaning)});
  }
  fields.push_back(number_field(
      "wire.resistance", kind::resistance_per_length, 1e-3, 1e5, resistance_slot,
      "resistance per length of the cold wire without load; scales all resistivities to it"));
  return fields;
}

/// The key that is written for this slot.
const Field& written_field(std::size_t slot) {
  return *std::ranges::find_if(wire_fields(), [&](const Field& field) {
    return field.slot <= slot && slot < field.slot + field.count;
  });
}

/// Whether the field's kind of unit differs from the row's, so that its numbers have to be
/// converted.
bool is_converted(const Field& field) {
  return field.slot < rows.size() && field.kind.data() != rows[field.slot].kind.data();
}

/// The phase that a path belongs to; `wire` may be const.
auto& phase_of(auto& wire, std::string_view path) {
  auto& m = wire.material;
  return path.starts_with("wire.martensite") ? m.martensite
         : path.starts_with("wire.r_phase")  ? m.r_phase
                                             : m.austenite;
}

class Builder {
 public:
  Builder(const Entries& entries, const WireFailure& fail) : entries_(entries), fail_(fail) {}

  Wire<double> build() {
    Wire<double> wire{};
    wire.kinetics.separate_r2a = has_process(Needs::own_r2a);
    wire.kinetics.separate_r2m = has_process(Needs::own_r2m);
    for (std::size_t slot = 0; slot < rows.size(); ++slot) {
      set(wire, slot);
    }
    if (const Entry* load = entry(stress_slot); is_converted(*load->field)) {
      wire.limits.stress_Pa = wire.stress_Pa(load->number);
    }
    set_resistivities(wire, 1);
    if (const Entry* resistance = entry(resistance_slot)) {
      const double ohm = resistance->number * wire.geometry.length_m;
      set_resistivities(wire, ohm / cold_resistance_ohm(wire));
    }
    return wire;
  }

 private:
  const Entry* entry(std::size_t slot) const {
    const auto at = entries_.find(slot);
    return at == entries_.end() ? nullptr : &at->second;
  }

  /// Whether the wire has this surface of its own: the flag decides, or without a flag whether it
  /// is given.
  bool has_process(Needs needs) const {
    const Entry* flag =
        entry(needs == Needs::own_r2a ? row_of("wire.separate_r2a") : row_of("wire.separate_r2m"));
    if (flag != nullptr) {
      return flag->number != 0;
    }
    return std::ranges::any_of(entries_, [&](const auto& e) {
      return e.first < rows.size() && rows[e.first].needs == needs;
    });
  }

  void set(Wire<double>& wire, std::size_t slot) const {
    const Row& row = rows[slot];
    if (!row.is_used(wire)) {
      return;
    }
    const Entry* given = entry(slot);
    const double number = given != nullptr           ? given->number
                          : std::isnan(row.standard) ? following(wire, slot)
                                                     : row.standard;
    row.set(wire, number);
  }

  /// The value of a slot that is not given and has no number as its default.
  double following(const Wire<double>& wire, std::size_t slot) const {
    const Row& row = rows[slot];
    if (row.type == ValueType::boolean) {
      return row.get(wire);
    }
    if (slot == row_of("wire.smallest_reversal_K")) {
      return wire.kinetics.memory == Memory::plain ? 0 : 0.5;
    }
    const StillAir air = still_air(wire.geometry.diameter_m);
    if (slot == row_of("wire.heat.convection_W_m2K")) {
      return air.convection_W_m2K;
    }
    if (slot == row_of("wire.heat.convection_slope_W_m2K2")) {
      return air.convection_W_m2K2;
    }
    missing(row, slot);
    return 0;
  }

  void missing(const Row& row, std::size_t slot) const {
    const std::string path = written_field(slot).path;
    if (row.needs == Needs::nothing) {
      fail_(path, "is missing");
    }
    fail_(path.substr(0, path.rfind('.')), "needs all of start, finish, curvature and turning");
  }

  /// Slopes may be given relative to the resistivity. A given resistance per length scales all
  /// resistivities and keeps their ratios.
  void set_resistivities(Wire<double>& wire, double scale) const {
    for (std::size_t slot = 0; slot < rows.size(); ++slot) {
      const std::string_view path = rows[slot].path.text();
      if (path.ends_with(".resistivity_ohm_m")) {
        Phase<double>& phase = phase_of(wire, path);
        const double rho = scale * entry(slot)->number;
        phase.resistivity_ohm_m = rho;
        phase.resistivity_ohm_m_K = slope(slot + 1, rho, scale);
        phase.resistivity_ohm_m_Pa = slope(slot + 2, rho, scale);
      }
    }
  }

  double slope(std::size_t slot, double rho, double scale) const {
    const Entry* given = entry(slot);
    return given == nullptr              ? rho * rows[slot].standard
           : is_converted(*given->field) ? rho * given->number
                                         : scale * given->number;
  }

  const Entries& entries_;
  const WireFailure& fail_;
};

/// Says which rule does not hold.
void fail_rule(const WireProblem& problem, const WireFailure& fail) {
  using enum WireProblem::Rule;
  constexpr const SurfaceRange& range = surface_range;
  const std::string process(problem.process);
  const std::string where = fmt::format(" at {:.4g} MPa", problem.stress_Pa / 1e6);
  const auto between = [&](const char* key, double min, double max) {
    fail(process + key,
         fmt::format("must be between {} and {}, is {:.4g}{}", min, max, problem.value, where));
  };
  switch (problem.rule) {
    case range_K:
      fail(process, fmt::format("start and finish must be between {} and {} K, one is {:.4g} K{}",
                                range.min_K, range.max_K, problem.value, where));
      break;
    case span_K:
      fail(process,
           fmt::format("finish must be at least {} K {} start, is {:.4g} K{}", range.min_span_K,
                       problem.heating ? "above" : "below", problem.value, where));
      break;
    case curvature:
      between(".curvature", range.min_curvature, range.max_curvature);
      break;
    case turning:
      between(".turning", range.min_turning, range.max_turning);
      break;
    case latent_heat:
      fail("wire.heat.latent_r2a",
           "must not be above wire.heat.latent_m2a: a closed cycle would gain heat");
      break;
  }
}

}  // namespace

FieldType field_type(ValueType type) {
  switch (type) {
    case ValueType::real:
      return FieldType::number;
    case ValueType::number:
      return FieldType::whole;
    case ValueType::choice:
      return FieldType::choice;
    case ValueType::boolean:
      break;
  }
  return FieldType::flag;
}

const std::vector<Field>& wire_fields() {
  static const std::vector<Field> fields = make_wire_fields();
  return fields;
}

bool is_needed(const Field& field) {
  return field.slot < rows.size() && std::isnan(rows[field.slot].standard) &&
         rows[field.slot].follows.empty() && rows[field.slot].needs == Needs::nothing;
}

std::vector<const Field*> written_fields(const Wire<double>& wire) {
  std::vector<const Field*> fields;
  std::size_t next = 0;
  for (const Field& field : wire_fields()) {
    const bool is_row = next <= field.slot && field.slot < rows.size();
    next = std::max(next, field.slot + field.count);
    // Flags are left out, because they follow from what is given.
    if (is_row && field.type != FieldType::flag && rows[field.slot].is_used(wire)) {
      fields.push_back(&field);
    }
  }
  return fields;
}

std::vector<double> wire_numbers(const Field& field, const Wire<double>& wire) {
  std::vector<double> numbers;
  numbers.reserve(field.count);
  for (std::size_t i = 0; i < field.count; ++i) {
    numbers.push_back(rows[field.slot + i].get(wire));
  }
  if (is_converted(field)) {
    numbers[0] = field.slot == stress_slot
                     ? numbers[0] * wire.geometry.area_m2()
                     : numbers[0] / phase_of(wire, field.path).resistivity_ohm_m;
  }
  return numbers;
}

Wire<double> build_wire(const Entries& entries, const WireFailure& fail) {
  return Builder(entries, fail).build();
}

void check_wire(const Wire<double>& wire, const WireFailure& fail) {
  check_wire_rules(wire, [&](const WireProblem& problem) { fail_rule(problem, fail); });
}

std::string where_said(const Entries& entries, const std::string& origin, std::string_view path) {
  const auto field = std::ranges::find(wire_fields(), path, &Field::path);
  const auto at = field == wire_fields().end() ? entries.end() : entries.find(field->slot);
  return at == entries.end() || at->second.where.empty() ? fmt::format("{}: {}", origin, path)
                                                         : at->second.where;
}

Entries describe_wire(const Wire<double>& wire) {
  Entries entries;
  for (const Field& field : wire_fields()) {
    if (field.slot >= rows.size() || field.count > 1 || field.type == FieldType::flag ||
        is_converted(field)) {
      continue;
    }
    const Row& row = rows[field.slot];
    if (row.is_used(wire)) {
      entries[field.slot] = {row.get(wire), &field, ""};
    }
  }
  return entries;
}

}  // namespace smaservo::files
