#include "model/units.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>

#include "host-sim/checks/findings.hpp"
#include "host-sim/checks/statistics.hpp"

namespace smaservo::checks {
namespace {

constexpr double max_record_strain = 0.2;
constexpr double max_stress_Pa = 1.5e9;
constexpr double min_stress_Pa = 1e6;  ///< makers load their wires with 30 to 300 MPa
constexpr double max_heating_K_s = 1e5;
/// Of NiTi in all its phases 0.7 to 1.1; strain and additions widen it.
constexpr double min_resistivity_ohm_m = 0.5e-6, max_resistivity_ohm_m = 1.5e-6;
/// Leads and clamps that were measured with the wire.
constexpr double two_wire_ohm_m = 1.25e-6;
constexpr double usual_resistivity_ohm_m = 0.9e-6;
constexpr double coldest_K = 150, hottest_K = 500;  ///< no NiTi wire transforms beyond
/// So much current flows in wires that are heated: 20 to 60 A/mm2 by the makers' tables.
constexpr double least_A_m2 = 2e6, most_A_m2 = 3e8;

const Place& place_of(const Record& record, hal::Column column) {
  return record.places[static_cast<std::size_t>(column)];
}

bool is_resistivity(double value_ohm_m) {
  return min_resistivity_ohm_m <= value_ohm_m && value_ohm_m <= max_resistivity_ohm_m;
}

/// The other unit of the kind whose use would have the readings times this factor, to a part in a
/// hundred.
std::optional<std::string> unit_for(const Place& place, Kind kind, double factor) {
  const auto now = std::ranges::find(kind, std::string_view(place.unit), &Unit::suffix);
  if (place.column == 0 || now == kind.end()) {
    return std::nullopt;
  }
  for (const Unit& other : kind) {
    if (std::abs(other.factor / now->factor / factor - 1) < 0.01) {
      return std::string(other.suffix);
    }
  }
  return std::nullopt;
}

double factor_of(Kind kind, const Place& place) {
  const auto found = std::ranges::find(kind, std::string_view(place.unit), &Unit::suffix);
  return found == kind.end() ? 1 : found->factor;
}

std::string option(std::string_view quantity, const Place& place, std::string_view unit) {
  return fmt::format("--column {}={}:{}", quantity, place.column, unit);
}

/// A resistance as the record has it, and where.
struct Measured {
  double ohm, ohm_m;
  std::size_t row;
  double densest_A_m2;  ///< largest current density
};

Measured measured(const Record& record, const RecordedWire& wire) {
  const double ohm = range_of(record.resistance_ohm).middle - wire.lead_resistance_ohm;
  std::size_t row = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < record.resistance_ohm.size(); ++i) {
    const double off = std::abs(record.resistance_ohm[i] - wire.lead_resistance_ohm - ohm);
    if (off < nearest) {
      nearest = off;
      row = i;
    }
  }
  double largest_A = 0;
  for (const double current_A : record.current_A) {
    largest_A = std::max(largest_A, std::abs(current_A));
  }
  const double area_m2 = wire.geometry.area_m2();
  return {ohm, ohm * area_m2 / wire.geometry.length_m, row, largest_A / area_m2};
}

/// Whether the current or the voltage stands in a unit that is a thousand times another.
std::optional<std::string> wrong_unit(const Record& record, const Measured& m) {
  const Place& current = place_of(record, hal::Column::current);
  const Place& voltage = place_of(record, hal::Column::voltage);
  for (const double factor : {1e3, 1e-3}) {
    if (!is_resistivity(m.ohm_m / factor)) {
      continue;
    }
    const bool plausible = least_A_m2 <= m.densest_A_m2 && m.densest_A_m2 <= most_A_m2;
    const auto current_unit = unit_for(current, kind::current, factor);
    const auto voltage_unit = unit_for(voltage, kind::voltage, 1 / factor);
    const auto said = [](const char* what, const Place& place, const std::string& unit) {
      return fmt::format("{} is probably in {} and not in {}: {}",
                         fmt::format("column {} '{}'", place.column, place.name), unit, place.unit,
                         option(what, place, unit));
    };
    if (current_unit && (!plausible || !voltage_unit)) {
      return said("current", current, *current_unit);
    }
    if (voltage_unit) {
      return said("voltage", voltage, *voltage_unit) +
             (current_unit
                  ? fmt::format(" (or the current: {})", option("current", current, *current_unit))
                  : "");
    }
  }
  return std::nullopt;
}

/// Whether current and voltage stand in each other's column.
std::optional<std::string> swapped(const Record& record, const RecordedWire& wire,
                                   const Measured& m) {
  const Place& current = place_of(record, hal::Column::current);
  const Place& voltage = place_of(record, hal::Column::voltage);
  if (current.column == 0 || voltage.column == 0 || current.column == voltage.column) {
    return std::nullopt;
  }
  // In the units that the names have: what is called current would be the voltage.
  const double ratio = factor_of(kind::voltage, voltage) / factor_of(kind::current, current);
  const double ohm_m = ratio * ratio / m.ohm * wire.geometry.area_m2() / wire.geometry.length_m;
  if (!is_resistivity(ohm_m)) {
    return std::nullopt;
  }
  return fmt::format("columns {} '{}' and {} '{}' are probably swapped: {} {}", current.column,
                     current.name, voltage.column, voltage.name,
                     option("current", voltage, current.unit),
                     option("voltage", current, voltage.unit));
}

/// Which other wire has this resistance.
std::string other_wire(const RecordedWire& wire, const Measured& m) {
  const Geometry<double>& g = wire.geometry;
  const double length_mm = 1e3 * m.ohm * g.area_m2() / usual_resistivity_ohm_m;
  const double diameter_um = 1e6 * g.diameter_m * std::sqrt(usual_resistivity_ohm_m / m.ohm_m);
  return fmt::format(
      "{}as 0.9 uohm_m, the wire would be {:.4g} mm long (--set wire.length_mm={:.4g}), or "
      "{:.4g} um thick (--set wire.diameter_um={:.4g}); check both, and the units of current and "
      "voltage",
      m.ohm_m > max_resistivity_ohm_m
          ? "leads and clamps may have been measured with it, in place of four wires; "
          : "",
      length_mm, length_mm, diameter_um, diameter_um);
}

void check_resistivity(const Record& record, const RecordedWire& wire, Findings& found) {
  if (known(record.resistance_ohm).empty()) {
    return;
  }
  const Measured m = measured(record, wire);
  if (!(m.ohm > 0)) {
    return;  // opposite signs, which check_signs() says
  }
  const std::string where =
      record.current_A.empty() || record.voltage_V.empty()
          ? fmt::format("{}, {}", record.row(m.row),
                        record.column(hal::Column::resistance, "its resistance"))
          : fmt::format("{}: {:.4g} V in {}, {:.4g} A in {}", record.row(m.row),
                        record.voltage_V[m.row], record.column(hal::Column::voltage, "one column"),
                        record.current_A[m.row], record.column(hal::Column::current, "another"));
  const std::string what = fmt::format(
      "a resistance of {:.4g} ohm ({}) means {:.3g} uohm_m for {:.4g} mm of {:.4g} um "
      "wire; NiTi has 0.5 to 1.5",
      m.ohm, where, 1e6 * m.ohm_m, 1e3 * wire.geometry.length_m, 1e6 * wire.geometry.diameter_m);
  if (is_resistivity(m.ohm_m)) {
    if (m.ohm_m > two_wire_ohm_m) {
      found.push_back(
          {"resistivity", false,
           fmt::format(
               "{} and mostly 0.7 to 1.1; if the leads were measured with the wire, take off "
               "their resistance: replay --set measurement.lead_resistance_ohm={:.2g}",
               what, m.ohm * (1 - usual_resistivity_ohm_m / m.ohm_m))});
    }
    return;
  }
  const Place& ohms = place_of(record, hal::Column::resistance);
  std::optional<std::string> cause;
  for (const double factor : {1e3, 1e-3}) {
    const auto unit = unit_for(ohms, kind::resistance, factor);
    if (unit && is_resistivity(m.ohm_m * factor)) {
      cause = fmt::format("{} is probably in {}: {}",
                          record.column(hal::Column::resistance, "the resistance"), *unit,
                          option("resistance", ohms, *unit));
    }
  }
  if (!cause) {
    cause = wrong_unit(record, m);
  }
  if (!cause) {
    cause = swapped(record, wire, m);
  }
  found.push_back(
      {"resistivity", true, fmt::format("{}; {}", what, cause ? *cause : other_wire(wire, m))});
}

void check_strain(const Record& record, const RecordedWire& wire, Findings& found) {
  const double span = span_of(record.strain);
  const Place& displacement = place_of(record, hal::Column::displacement);
  const bool of_displacement =
      displacement.column > 0 && place_of(record, hal::Column::strain_ref).column == 0;
  const auto moves_as_a_wire = [](double strain) { return 0.002 < strain && strain < 0.12; };
  const auto unit_that_fits = [&]() -> std::string {
    for (const double factor : {1e-3, 1e3, 1e-6, 1e6}) {
      const auto unit = unit_for(displacement, kind::length, factor);
      if (of_displacement && unit && moves_as_a_wire(factor * span)) {
        return fmt::format("; {} is probably in {}: {}",
                           record.column(hal::Column::displacement, ""), *unit,
                           option("displacement", displacement, *unit));
      }
    }
    return "";
  };
  if (span > max_record_strain) {
    const std::string unit = unit_that_fits();
    found.push_back(
        {"strain", true,
         fmt::format(
             "the strain spans {:.3g} ({}), and no wire survives more than {}{}", span,
             record.column(of_displacement ? hal::Column::displacement : hal::Column::strain_ref,
                           "no column"),
             max_record_strain,
             !unit.empty() ? unit
                           : fmt::format("; a strain in per cent is strain_ref_percent; for a "
                                         "displacement, check its unit and the length of the wire "
                                         "({:.4g} mm)",
                                         1e3 * wire.geometry.length_m))});
  } else if (const std::string unit = unit_that_fits();
             of_displacement && span < 2e-4 && !unit.empty()) {
    found.push_back({"strain", true,
                     fmt::format("the wire moves by {:.2g} m in all, {:.1g} % of its length{}",
                                 span * wire.geometry.length_m, 100 * span, unit)});
  }
}

/// What a load may be in where the stress is impossible.
std::string cause_of_load(const Record& record, double largest_Pa, const RecordedWire& wire) {
  const Place& load = place_of(record, hal::Column::load);
  if (load.column == 0) {
    return fmt::format("check the unit, and the diameter (of {:.4g} um)",
                       1e6 * wire.geometry.diameter_m);
  }
  const double area_m2 = wire.geometry.area_m2();
  const double unit = load.unit == "N" ? 1 : load.unit == "mN" ? 1e-3 : 9.80665e-3;
  const bool counts = largest_Pa * area_m2 / unit > 5000 &&
                      std::ranges::all_of(record.stress_Pa, [&](double stress_Pa) {
                        const double reading = stress_Pa * area_m2 / unit;
                        return std::abs(reading - std::round(reading)) < 1e-6 * std::abs(reading);
                      });
  if (counts) {
    return fmt::format(
        "the whole numbers in {} are probably counts of a converter, which need their factor: "
        "--column load_N={}*NEWTONS_PER_COUNT",
        record.column(hal::Column::load, ""), load.column);
  }
  for (const auto& [other, factor] : {std::pair("gf", 9.80665e-3), std::pair("mN", 1e-3)}) {
    if (load.unit == "N" && largest_Pa * factor < max_stress_Pa) {
      return fmt::format("{} is probably in {}: {}", record.column(hal::Column::load, ""),
                         std::string_view(other) == "gf" ? "grams" : other,
                         option("load", load, other));
    }
  }
  return fmt::format("check the unit of {}, and the diameter (of {:.4g} um)",
                     record.column(hal::Column::load, ""), 1e6 * wire.geometry.diameter_m);
}

void check_stress(const Record& record, const RecordedWire& wire, Findings& found) {
  if (record.stress_Pa.empty() || record.kind == RunKind::calorimetry) {
    return;
  }
  const auto largest = std::ranges::max_element(record.stress_Pa);
  if (*largest > max_stress_Pa) {
    found.push_back(
        {"stress", true,
         fmt::format("the stress reaches {:.4g} MPa ({}), and above {} MPa a wire breaks; {}",
                     1e-6 * *largest,
                     record.row(static_cast<std::size_t>(largest - record.stress_Pa.begin())),
                     1e-6 * max_stress_Pa, cause_of_load(record, *largest, wire))});
    return;
  }
  const Place& load = place_of(record, hal::Column::load);
  if (load.column == 0 || record.kind != RunKind::joule) {
    return;
  }
  const Range range = range_of(record.stress_Pa);
  if (0 <= range.middle && range.high < min_stress_Pa) {
    std::string cause = "is the load cell connected, and its unit right?";
    for (const auto& [other, factor] : {std::pair("N", 1 / 9.80665e-3), std::pair("N", 1e3)}) {
      const std::string_view now = factor == 1e3 ? "mN" : "gf";
      if (load.unit == now && range.middle * factor > 10e6 && range.high * factor < 1e9) {
        cause = fmt::format("it is probably in {}: {}", other, option("load", load, other));
      }
    }
    found.push_back(
        {"load", false,
         fmt::format("the load is at most {:.2g} MPa ({}), and wires work at 30 to 300 MPa; {}",
                     1e-6 * range.high, record.column(hal::Column::load, ""), cause)});
  }
}

void check_temperature(const Record& record, Findings& found) {
  const bool by_temperature = record.kind == RunKind::bath || record.kind == RunKind::calorimetry;
  if (!by_temperature || record.temperature_K.empty()) {
    return;
  }
  const auto [coldest, hottest] = std::ranges::minmax(record.temperature_K);
  if (hottest < coldest_K || coldest > hottest_K) {
    const Place& place = place_of(record, hal::Column::temperature);
    const std::string_view other = hottest < coldest_K ? "degC" : "K";
    found.push_back(
        {"temperature", true,
         fmt::format(
             "temperatures are {:.4g} to {:.4g} K ({:.4g} to {:.4g} degC), and no NiTi wire "
             "transforms beyond {} to {} K; {}{}",
             coldest, hottest, coldest - zero_degC_K, hottest - zero_degC_K, coldest_K, hottest_K,
             hottest < coldest_K ? "are they degC in a column of K?"
                                 : "are they K in a column of degC?",
             place.column == 0 ? "" : " " + option("temperature", place, other))});
  }
}

void check_heating_rate(const Record& record, const RecordedWire& wire, Findings& found) {
  const double heat_J_K =
      density_kg_m3 * specific_heat_J_kgK * wire.geometry.area_m2() * wire.geometry.length_m;
  for (std::size_t i = 0; i < std::min(record.current_A.size(), record.voltage_V.size()); ++i) {
    const double power_W = record.current_A[i] * record.voltage_V[i];
    if (power_W > max_heating_K_s * heat_J_K) {
      const Place& current = place_of(record, hal::Column::current);
      const Place& voltage = place_of(record, hal::Column::voltage);
      const bool thousands =
          current.unit == "A" && voltage.unit == "V" && power_W * 1e-6 < max_heating_K_s * heat_J_K;
      found.push_back(
          {"heat", true,
           fmt::format("{}: {:.4g} A at {:.4g} V would heat the wire by {:.2g} K/s; {}",
                       record.row(i), record.current_A[i], record.voltage_V[i], power_W / heat_J_K,
                       thousands ? fmt::format("they are probably in mA and mV: {} {}",
                                               option("current", current, "mA"),
                                               option("voltage", voltage, "mV"))
                                 : "check the units, length and diameter")});
      return;
    }
  }
}

}  // namespace

void check_units(const Record& record, const RecordedWire& wire, Findings& found) {
  check_strain(record, wire, found);
  check_stress(record, wire, found);
  check_temperature(record, found);
  check_resistivity(record, wire, found);
  check_heating_rate(record, wire, found);
}

}  // namespace smaservo::checks
