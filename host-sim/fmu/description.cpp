#include "host-sim/fmu/description.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

#include "model/files/message.hpp"
#include "model/units.hpp"

namespace smaservo::fmu {
namespace {

using unit::Role;
using unit::Type;
using unit::Variable;

/// A unit of this project with its name for FMI and its exponents of kg, m, s, A and K.
struct FmiUnit {
  std::string_view suffix, name;
  int kg, m, s, A, K;
  // NOLINTNEXTLINE(readability-redundant-member-init): for designated initializers
  std::string_view display = {};  ///< a unit for people; "": none
  double display_factor = 1;
};

constexpr auto fmi_units = std::to_array<FmiUnit>({
    {"", "1", 0, 0, 0, 0, 0, "%", 100},
    {"s", "s", 0, 0, 1, 0, 0, "ms", 1e3},
    {"K", "K", 0, 0, 0, 0, 1},
    {"m", "m", 0, 1, 0, 0, 0, "mm", 1e3},
    {"A", "A", 0, 0, 0, 1, 0, "mA", 1e3},
    {"V", "V", 1, 2, -3, -1, 0, "mV", 1e3},
    {"ohm", "Ohm", 1, 2, -3, -2, 0},
    {"N", "N", 1, 1, -2, 0, 0, "mN", 1e3},
    {"Pa", "Pa", 1, -1, -2, 0, 0, "MPa", 1e-6},
    {"W", "W", 1, 2, -3, 0, 0, "mW", 1e3},
    {"ohm_m", "Ohm.m", 1, 3, -3, -2, 0},
    {"ohm_m_K", "Ohm.m/K", 1, 3, -3, -2, -1},
    {"ohm_m_Pa", "Ohm.m/Pa", 0, 4, -1, -2, 0},
    {"1_Pa", "1/Pa", -1, 1, 2, 0, 0},
    {"1_s", "1/s", 0, 0, -1, 0, 0},
    {"A_s", "A/s", 0, 0, -1, 1, 0},
    {"K_s", "K/s", 0, 0, -1, 0, 1},
    {"K_Pa", "K/Pa", -1, 1, 2, 0, 1},
    {"K_Pa2", "K/Pa2", -2, 2, 4, 0, 1},
    {"kg_m3", "kg/m3", 1, -3, 0, 0, 0},
    {"J_kgK", "J/(kg.K)", 0, 2, -2, 0, -1},
    {"J_kg", "J/kg", 0, 2, -2, 0, 0},
    {"W_m2K", "W/(m2.K)", 1, 0, -3, 0, -1},
    {"W_m2K2", "W/(m2.K2)", 1, 0, -3, 0, -2},
    {"W_mK", "W/(m.K)", 1, 1, -3, 0, -1},
    {"W_K", "W/K", 1, 2, -3, 0, -1},
    {"W_ohm", "W/Ohm", 0, 0, 0, 2, 0},
    {"W_N", "W/N", 0, 1, -1, 0, 0},
});

const FmiUnit& fmi_unit(std::string_view suffix) {
  const auto* const at = std::ranges::find(fmi_units, suffix, &FmiUnit::suffix);
  if (at == fmi_units.end()) {
    throw std::logic_error(fmt::format("no unit of FMI for {}", suffix));
  }
  return *at;
}

/// A text as the value of an attribute, or between tags.
std::string escaped(std::string_view text) {
  std::string result;
  for (const char letter : files::printable(text)) {
    switch (letter) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += letter;
    }
  }
  return result;
}

std::string attribute(std::string_view name, std::string_view value) {
  return fmt::format(" {}=\"{}\"", name, escaped(value));
}

std::string number(double value) {
  return fmt::format("{}", value);
}

/// The name of the type that a choice has.
std::string type_of(const Variable& v) {
  // The same names are the same type: mode and mode_in_force.
  std::string name = "Choice";
  for (const std::string_view choice : v.choices) {
    name += '_';
    for (const char letter : choice.substr(0, 12)) {
      name += letter == '-' ? '_' : letter;
    }
    if (name.size() > 60) {
      break;
    }
  }
  return name;
}

bool has_start(const Variable& v) {
  return v.role == Role::parameter || v.role == Role::input;
}

bool is_continuous(const Variable& v) {
  return v.type == Type::real && !v.sampled;
}

std::string_view causality(Role role) {
  constexpr std::array<std::string_view, 4> names{"independent", "parameter", "input", "output"};
  return names.at(static_cast<std::size_t>(role));
}

/// Attributes that a variable has in both versions.
std::string common_attributes(const Variable& v, std::size_t reference) {
  std::string all = attribute("name", v.name) + fmt::format(" valueReference=\"{}\"", reference) +
                    attribute("description", v.description) +
                    attribute("causality", causality(v.role)) +
                    attribute("variability", v.role == Role::parameter ? "fixed"
                                             : is_continuous(v)        ? "continuous"
                                                                       : "discrete");
  if (v.role == Role::parameter) {
    all += attribute("initial", "exact");
  } else if (v.role == Role::output) {
    all += attribute("initial", "calculated");
  }
  return all;
}

/// Unit, range and start value; no range where none is meant.
std::string value_attributes(const Variable& v, double start) {
  std::string all;
  if (v.type == Type::choice) {
    all += attribute("declaredType", type_of(v));
  }
  if (v.type == Type::real) {
    const FmiUnit& unit = fmi_unit(v.unit);
    all += attribute("unit", unit.name);
    if (v.absolute_K) {
      all += attribute("displayUnit", "degC");
    } else if (v.unit == "K") {
      all += attribute("relativeQuantity", "true");
    }
  }
  if (!std::isnan(v.min)) {
    all += attribute("min", number(v.min));
  }
  if (!std::isnan(v.max)) {
    all += attribute("max", number(v.max));
  }
  if (has_start(v)) {
    all +=
        attribute("start", v.type == Type::flag ? (start != 0 ? "true" : "false") : number(start));
  }
  return all;
}

std::string unit_definitions(const Description& d) {
  std::string all = "  <UnitDefinitions>\n";
  for (const FmiUnit& unit : fmi_units) {
    const bool used = std::ranges::any_of(d.variables, [&](const Variable& v) {
      return v.type == Type::real && v.unit == unit.suffix;
    });
    if (!used) {
      continue;
    }
    std::string base;
    const auto exponent = [&](const char* name, int value) {
      base += value == 0 ? "" : fmt::format(" {}=\"{}\"", name, value);
    };
    exponent("kg", unit.kg);
    exponent("m", unit.m);
    exponent("s", unit.s);
    exponent("A", unit.A);
    exponent("K", unit.K);
    all += fmt::format("    <Unit{}>\n      <BaseUnit{}/>\n", attribute("name", unit.name), base);
    if (unit.suffix == "K") {
      all += fmt::format("      <DisplayUnit name=\"degC\" offset=\"{}\"/>\n", -zero_degC_K);
    } else if (!unit.display.empty()) {
      all += fmt::format("      <DisplayUnit{} factor=\"{}\"/>\n", attribute("name", unit.display),
                         number(unit.display_factor));
    }
    all += "    </Unit>\n";
  }
  return all + "  </UnitDefinitions>\n";
}

std::string type_definitions(const Description& d, Version version) {
  std::string all;
  std::vector<std::string> done;
  for (const Variable& v : d.variables) {
    const std::string name = v.type == Type::choice ? type_of(v) : "";
    if (name.empty() || std::ranges::find(done, name) != done.end()) {
      continue;
    }
    done.push_back(name);
    std::string items;
    for (std::size_t i = 0; i < v.choices.size(); ++i) {
      items += fmt::format("        <Item{} value=\"{}\"/>\n", attribute("name", v.choices[i]), i);
    }
    all += version == Version::fmi2
               ? fmt::format(
                     "    <SimpleType{}>\n      <Enumeration>\n{}      </Enumeration>\n"
                     "    </SimpleType>\n",
                     attribute("name", name), items)
               : fmt::format("    <EnumerationType{}>\n{}    </EnumerationType>\n",
                             attribute("name", name), items);
  }
  return all.empty() ? "" : "  <TypeDefinitions>\n" + all + "  </TypeDefinitions>\n";
}

std::string variables_xml(const Description& d, Version version) {
  constexpr std::array<std::string_view, 4> fmi2_types{"Real", "Integer", "Enumeration", "Boolean"};
  constexpr std::array<std::string_view, 4> fmi3_types{"Float64", "Int32", "Enumeration",
                                                       "Boolean"};
  std::string all = "  <ModelVariables>\n";
  for (std::size_t i = 0; i < d.variables.size(); ++i) {
    const Variable& v = d.variables[i];
    const auto type = static_cast<std::size_t>(v.type);
    const std::string common = common_attributes(v, i);
    const std::string value = value_attributes(v, d.start[i]);
    all += version == Version::fmi2
               ? fmt::format("    <ScalarVariable{}>\n      <{}{}/>\n    </ScalarVariable>\n",
                             common, fmi2_types.at(type), value)
               : fmt::format("    <{}{}{}/>\n", fmi3_types.at(type), common, value);
  }
  return all + "  </ModelVariables>\n";
}

/// Outputs at a communication point follow from the steps before it, and at the beginning from all
/// parameters and inputs.
std::string model_structure(const Description& d, Version version) {
  std::string outputs;
  std::string initial;
  for (std::size_t i = 0; i < d.variables.size(); ++i) {
    if (d.variables[i].role != Role::output) {
      continue;
    }
    if (version == Version::fmi2) {
      outputs += fmt::format("      <Unknown index=\"{}\" dependencies=\"\"/>\n", i + 1);
      initial += fmt::format("      <Unknown index=\"{}\"/>\n", i + 1);
    } else {
      outputs += fmt::format("    <Output valueReference=\"{}\" dependencies=\"\"/>\n", i);
      initial += fmt::format("    <InitialUnknown valueReference=\"{}\"/>\n", i);
    }
  }
  if (version == Version::fmi2) {
    outputs = "    <Outputs>\n" + outputs + "    </Outputs>\n";
    initial = "    <InitialUnknowns>\n" + initial + "    </InitialUnknowns>\n";
  }
  return "  <ModelStructure>\n" + outputs + initial + "  </ModelStructure>\n";
}

std::string interface_type(const Description& d, Version version) {
  const bool two = version == Version::fmi2;
  std::string all = "  <CoSimulation" + attribute("modelIdentifier", identifier(d.kind)) +
                    " canHandleVariableCommunicationStepSize=\"true\"";
  all += two ? " canNotUseMemoryManagementFunctions=\"true\" canGetAndSetFMUstate=\"true\""
               " canSerializeFMUstate=\"true\">\n    <SourceFiles>\n"
             : " canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\"/>\n";
  if (two) {
    for (const std::string& source : d.sources) {
      all += "      <File" + attribute("name", source) + "/>\n";
    }
    all += "    </SourceFiles>\n  </CoSimulation>\n";
  }
  return all;
}

std::string what(const Description& d) {
  return d.kind == Kind::wire
             ? "A wire of shape-memory alloy: current and load in, strain and resistance out."
             : "A wire of shape-memory alloy with the servo that drives it: set-point and load in, "
               "strain out.";
}

std::string with_token(const Description& d, Version version, const std::string& token) {
  const bool two = version == Version::fmi2;
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription" +
         attribute("fmiVersion", two ? "2.0" : "3.0") +
         attribute("modelName", identifier(d.kind) + " " + d.name) +
         attribute(two ? "guid" : "instantiationToken", token) + attribute("description", what(d)) +
         attribute("license", "MIT") + attribute("generationTool", "smaservo " SMASERVO_VERSION) +
         attribute("variableNamingConvention", "structured") + ">\n" + interface_type(d, version) +
         unit_definitions(d) + type_definitions(d, version) +
         "  <LogCategories>\n    <Category name=\"logStatusError\"/>\n  </LogCategories>\n" +
         fmt::format("  <DefaultExperiment startTime=\"0\" stopTime=\"10\" stepSize=\"{}\"/>\n",
                     number(d.step_s)) +
         variables_xml(d, version) + model_structure(d, version) + "</fmiModelDescription>\n";
}

}  // namespace

std::string identifier(Kind kind) {
  return kind == Kind::wire ? "smaservo_wire" : "smaservo_servo";
}

std::string token_of(const Description& description, Version version) {
  std::string all = with_token(description, version, "");
  for (const auto& [name, value] : description.constants) {
    all += fmt::format("{}={}\n", name, value);
  }
  // FNV-1a from two beginnings.
  std::array<std::uint64_t, 2> hash{0xCBF29CE484222325U, 0x9AE16A3B2F90404FU};
  for (std::uint64_t& h : hash) {
    for (const char letter : all) {
      h = (h ^ static_cast<unsigned char>(letter)) * 0x100000001B3U;
    }
  }
  return fmt::format("{{{:08x}-{:04x}-{:04x}-{:04x}-{:012x}}}", hash[0] >> 32U,
                     hash[0] >> 16U & 0xFFFFU, hash[0] & 0xFFFFU, hash[1] >> 48U,
                     hash[1] & 0xFFFFFFFFFFFFU);
}

std::string model_description(const Description& description, Version version) {
  return with_token(description, version, token_of(description, version));
}

std::string build_description(const Description& description) {
  std::string all =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n"
      "  <BuildConfiguration" +
      attribute("modelIdentifier", identifier(description.kind)) +
      ">\n    <SourceFileSet language=\"C++20\" compilerOptions=\"-O2 -ffp-contract=off\">\n";
  for (const std::string& source : description.sources) {
    all += "      <SourceFile" + attribute("name", source) + "/>\n";
  }
  return all +
         "      <IncludeDirectory name=\".\"/>\n    </SourceFileSet>\n  </BuildConfiguration>\n"
         "</fmiBuildDescription>\n";
}

std::string values_file(const Description& description, Version version) {
  std::string all =
      fmt::format("kind = {}\ntoken = {}\ninterface = {:016x}\n",
                  description.kind == Kind::wire ? "wire" : "servo", token_of(description, version),
                  unit::interface_of(description.variables));
  for (const auto& [name, value] : description.constants) {
    all += fmt::format("{} = {}\n", name, value);
  }
  for (std::size_t i = 0; i < description.variables.size(); ++i) {
    if (has_start(description.variables[i])) {
      all += fmt::format("{} = {}\n", description.variables[i].name, description.start[i]);
    }
  }
  return all;
}

std::string documentation(const Description& description) {
  std::string all = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title></head>\n"
      "<body><h1>{0}</h1>\n<p>{1}</p>\n<p>Made of <code>{2}</code> by host-sim export-fmu, "
      "smaservo "
      "{3}. What steps do, and what equals what, is told in host-sim/fmu/README.md of that "
      "project.</p>\n<table>\n<tr><th>variable</th><th>what</th><th>unit</th><th>start</th>"
      "<th>meaning</th></tr>\n",
      identifier(description.kind), what(description), escaped(description.name), SMASERVO_VERSION);
  for (std::size_t i = 0; i < description.variables.size(); ++i) {
    const Variable& v = description.variables[i];
    all += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                       escaped(v.name), causality(v.role),
                       v.type == Type::real ? fmi_unit(v.unit).name : "",
                       has_start(v) ? number(description.start[i]) : "", escaped(v.description));
  }
  return all + "</table></body></html>\n";
}

}  // namespace smaservo::fmu
