#include "hal/replay/sheet/meaning.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <span>
#include <utility>

#include "hal/recording/trimmed.hpp"

namespace smaservo::hal {
namespace {

struct WrittenUnit {
  std::string_view written, own;
  double scale = 1;
};

constexpr auto time_units = std::to_array<WrittenUnit>({{"s", "s"},
                                                        {"sec", "s"},
                                                        {"seconds", "s"},
                                                        {"ms", "ms"},
                                                        {"msec", "ms"},
                                                        {"millis", "ms"},
                                                        {"us", "us"},
                                                        {"usec", "us"},
                                                        {"micros", "us"},
                                                        {"min", "s", 60},
                                                        {"X_Value", "s"}});  // of LabVIEW
constexpr auto current_units = std::to_array<WrittenUnit>(
    {{"A", "A"}, {"Amp", "A"}, {"Amps", "A"}, {"Ampere", "A"}, {"mA", "mA"}, {"uA", "mA", 1e-3}});
constexpr auto voltage_units = std::to_array<WrittenUnit>(
    {{"V", "V"}, {"Volt", "V"}, {"Volts", "V"}, {"mV", "mV"}, {"uV", "mV", 1e-3}});
constexpr auto force_units = std::to_array<WrittenUnit>({{"N", "N"},
                                                         {"mN", "mN"},
                                                         {"kN", "N", 1e3},
                                                         {"Newton", "N"},
                                                         {"gram", "gf"},
                                                         {"grams", "gf"},
                                                         {"g", "gf"},
                                                         {"gf", "gf"},
                                                         {"kg", "gf", 1e3},
                                                         {"kgf", "gf", 1e3},
                                                         {"lbf", "N", 4.4482216152605},
                                                         {"lb", "N", 4.4482216152605}});
constexpr auto stress_units = std::to_array<WrittenUnit>({{"Pa", "Pa"},
                                                          {"kPa", "kPa"},
                                                          {"MPa", "MPa"},
                                                          {"GPa", "GPa"},
                                                          {"psi", "Pa", 6894.757293168},
                                                          {"ksi", "kPa", 6894.757293168}});
constexpr auto temperature_units =
    std::to_array<WrittenUnit>({{"degC", "degC"}, {"C", "degC"}, {"K", "K"}});
constexpr auto length_units = std::to_array<WrittenUnit>({{"m", "m"},
                                                          {"mm", "mm"},
                                                          {"cm", "mm", 10},
                                                          {"um", "um"},
                                                          {"micron", "um"},
                                                          {"inch", "mm", 25.4}});
constexpr auto resistance_units = std::to_array<WrittenUnit>(
    {{"ohm", "ohm"}, {"ohms", "ohm"}, {"mohm", "mohm"}, {"kohm", "ohm", 1e3}});
constexpr auto strain_units =
    std::to_array<WrittenUnit>({{"percent", "percent"}, {"%", "percent"}});

struct Quantity {
  std::string_view base;
  std::span<const WrittenUnit> units;
  std::array<std::string_view, 16> names;  ///< in lower case, without blanks and underscores
};

struct Doubtful {
  Quantity quantity;
  std::string_view why;
};

constexpr auto quantities = std::to_array<Quantity>({
    {"time",
     time_units,
     {"t", "time", "zeit", "elapsedtime", "elapsed", "timestamp", "xvalue", "millis", "micros",
      "seconds", "datetime", "date/time", "zeitstempel", "temps", "tempo"}},
    {"current",
     current_units,
     {"i", "current", "strom", "iwire", "wirecurrent", "courant", "amps", "ampere", "imeas",
      "isense", "corrente", "corriente"}},
    {"voltage",
     voltage_units,
     {"u", "v", "voltage", "spannung", "uwire", "vwire", "wirevoltage", "vsense", "tension",
      "volts", "vmeas", "umeas", "usense", "tensione"}},
    {"load",
     force_units,
     {"f", "force", "kraft", "load", "last", "loadcell", "tensileforce", "pull", "zugkraft",
      "weight", "gewicht", "fload"}},
    {"stress", stress_units, {"sigma", "stress", "spannungmechanisch", "tensilestress"}},
    {"temperature", temperature_units, {"wiretemperature", "wiretemp", "twire", "drahttemperatur"}},
    {"ambient",
     temperature_units,
     {"ambient", "ambienttemperature", "ambienttemp", "tamb", "tambient", "roomtemperature",
      "umgebungstemperatur", "raumtemperatur"}},
    {"displacement", length_units, {"disp", "displacement", "weg", "stroke", "contraction", "hub"}},
    {"resistance", resistance_units, {"r", "resistance", "widerstand", "rwire"}},
});

/// Names that leave open what is meant.
const auto doubtful = std::to_array<Doubtful>({
    {{"displacement",
      length_units,
      {"position", "pos", "x", "lvdt", "laser", "laserdistance", "extension", "elongation",
       "distance", "abstand", "length", "dehnweg"}},
     "whether it grows or falls where the wire gets shorter is not told"},
    {{"temperature",
      temperature_units,
      {"temperature", "temp", "temperatur", "thermocouple", "tc"}},
     "whether it is that of the wire or of the air (ambient) is not told"},
});

constexpr auto others_units = std::to_array<std::string_view>(
    {"W", "mW", "Hz", "-", "1", "rad", "deg", "bar", "mbar", "rpm", "J", "K/s", "N/mm", "a.u."});

/// The signs for micro, ohm and degree by letters; blanks, and a full stop behind, do not count.
std::string plain_unit(std::string_view text) {
  constexpr std::pair<std::string_view, std::string_view> signs[] = {
      {"\u00B5", "u"},   {"\u03BC", "u"},   {"\u03A9", "ohm"},
      {"\u2126", "ohm"}, {"\u00B0", "deg"}, {"\u2103", "degC"}};
  std::string plain;
  while (!text.empty()) {
    const auto* const sign =
        std::ranges::find_if(signs, [&](const auto& s) { return text.starts_with(s.first); });
    if (sign != std::end(signs)) {
      plain += sign->second;
      text.remove_prefix(sign->first.size());
    } else {
      plain += text.front() == ' ' ? "" : std::string(1, text.front());
      text.remove_prefix(1);
    }
  }
  return plain;
}

std::string plain_name(std::string_view text) {
  std::string plain;
  for (const char c : text) {
    if (c != ' ' && c != '_' && c != '-' && c != '.') {
      plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return plain;
}

/// Units are told apart by their case, since mN and MN are not the same; only where nothing else
/// fits a unit of several letters counts in any case, as `Sec` and `OHM`.
const WrittenUnit* find_unit(std::span<const WrittenUnit> units, const std::string& written) {
  for (const WrittenUnit& unit : units) {
    if (unit.written == written) {
      return &unit;
    }
  }
  if (written.size() < 3) {
    return nullptr;
  }
  const std::string lower = plain_name(written);
  for (const WrittenUnit& unit : units) {
    if (unit.written.size() > 2 && plain_name(unit.written) == lower) {
      return &unit;
    }
  }
  return nullptr;
}

struct NameAndUnit {
  std::string_view name, unit;
};

/// Splits `I [mA]`, `I (mA)`, `I / mA`, `I in mA`, `I, mA` and `I_mA`; the unit is empty if there
/// is none.
NameAndUnit split(std::string_view text) {
  text = trimmed(text);
  for (const auto& [open, close] :
       {std::pair('[', ']'), std::pair('(', ')'), std::pair('{', '}')}) {
    const std::size_t at = text.rfind(open);
    if (at != std::string_view::npos && text.back() == close) {
      return {trimmed(text.substr(0, at)), trimmed(text.substr(at + 1, text.size() - at - 2))};
    }
  }
  for (const std::string_view between : {"/", " in ", ";", ",", "_", " "}) {
    const std::size_t at = text.rfind(between);
    if (at != std::string_view::npos) {
      return {trimmed(text.substr(0, at)), trimmed(text.substr(at + between.size()))};
    }
  }
  return {text, {}};
}

bool has_name(const Quantity& quantity, const std::string& plain) {
  return !plain.empty() && std::ranges::find(quantity.names, plain) != quantity.names.end();
}

const Quantity* find_quantity(std::string_view name) {
  const std::string plain = plain_name(name);
  // A logger counts its channels: `Voltage_0`.
  const std::string unnumbered = plain.substr(0, plain.find_last_not_of("0123456789") + 1);
  for (const Quantity& quantity : quantities) {
    if (has_name(quantity, plain) ||
        (has_name(quantity, unnumbered) && quantity.base != "resistance")) {
      return &quantity;
    }
  }
  return nullptr;
}

std::optional<Meaning> doubtful_meaning(std::string_view name, const NameAndUnit& parts) {
  for (const auto& [quantity, why] : doubtful) {
    const WrittenUnit* unit = find_unit(quantity.units, plain_unit(parts.unit));
    const bool whole = has_name(quantity, plain_name(name));
    if (whole || (unit != nullptr && has_name(quantity, plain_name(parts.name)))) {
      return unit == nullptr || whole
                 ? Meaning{quantity.base, {}, 1, {}, why}
                 : Meaning{quantity.base, unit->own, unit->scale, std::string(parts.unit), why};
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<Meaning> meaning_of(std::string_view name) {
  const NameAndUnit parts = split(name);
  const auto& [before, behind] = parts;
  if (const Quantity* quantity = find_quantity(before); quantity != nullptr && !behind.empty()) {
    const WrittenUnit* unit = find_unit(quantity->units, plain_unit(behind));
    if (unit != nullptr) {
      return Meaning{quantity->base, unit->own, unit->scale, std::string(behind), {}};
    }
  }
  const Quantity* quantity = find_quantity(name);
  if (quantity == nullptr) {
    return doubtful_meaning(name, parts);
  }
  // The names of an Arduino's clocks are units, too.
  const WrittenUnit* clock = find_unit(quantity->units, plain_name(name));
  return clock != nullptr && clock->written.size() > 2
             ? Meaning{quantity->base, clock->own, clock->scale, std::string(trimmed(name)), {}}
             : Meaning{quantity->base, {}, 1, {}, {}};
}

bool is_unit_field(std::string_view text) {
  text = trimmed(text);
  if (text.size() > 1 && (text.front() == '[' || text.front() == '(')) {
    text = trimmed(text.substr(1, text.size() - 2));
  }
  const std::string unit = plain_unit(text);
  return unit.empty() || std::ranges::find(others_units, unit) != others_units.end() ||
         std::ranges::any_of(quantities, [&](const Quantity& quantity) {
           return find_unit(quantity.units, unit) != nullptr;
         });
}

}  // namespace smaservo::hal
