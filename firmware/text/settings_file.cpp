#include "firmware/text/settings_file.hpp"

#include <fmt/format.h>

#include "firmware/text/settings_text.hpp"
#include "model/files/error.hpp"
#include "model/files/input_file.hpp"
#include "model/files/toml/toml_fields.hpp"
#include "model/files/wire/wire_fields.hpp"

namespace smaservo::text {
namespace {

using Row = Parameter<double>;

files::Field field_of(const Row& row, std::size_t slot) {
  const auto limit = [&](Value value) { return std::stod(value_text(row, value)); };
  const bool counts = row.type == ValueType::real || row.type == ValueType::number;
  const KeyParts parts = key_parts(row);
  return {fmt::format("{}.{}", parts.table, parts.name),
          files::field_type(row.type),
          row.type == ValueType::real ? row.kind : kind::count,
          counts ? limit(row.min) : 0,
          counts ? limit(row.max) : 0,
          slot,
          1,
          row.choices,
          ""};
}

/// The parameters of the wire, which are the last rows, get the slots of a wire file; the others
/// follow after these.
constexpr std::size_t device_rows = parameter_count - wire_parameter_count;
constexpr std::size_t slot_of(std::size_t row) {
  return row < device_rows ? files::wire_slot_count + row : row - device_rows;
}

const std::vector<files::Field>& settings_fields() {
  static const std::vector<files::Field> fields = [] {
    std::vector<files::Field> all;
    all.reserve(device_rows + files::wire_fields().size());
    for (std::size_t i = 0; i < device_rows; ++i) {
      all.push_back(field_of(parameters<double>[i], slot_of(i)));
    }
    all.insert(all.end(), files::wire_fields().begin(), files::wire_fields().end());
    return all;
  }();
  return fields;
}

Value value_of(const Row& row, double number) {
  return row.type == ValueType::real ? Value::real(static_cast<float>(number))
                                     : Value::number(static_cast<std::uint32_t>(number));
}

/// What a file and the overrides after it set.
struct GivenSettings {
  files::Entries values;
  std::string wire;        ///< preset or path of a file; empty: none is named
  std::string wire_where;  ///< "FILE:LINE: KEY = VALUE"
};

/// Adds the keys of a file or an override to `gathered`, replacing earlier ones. A wire file is
/// looked for in `folder`.
void read_settings(const toml::table& table, const std::string& origin,
                   const std::filesystem::path& folder, GivenSettings& gathered) {
  const auto take_wire = [&](const std::string& key, const toml::node& node) {
    if (key != "wire.based_on" && (key != "wire" || node.is_table())) {
      return false;
    }
    const auto name = node.value<std::string>();
    gathered.wire_where = files::place(origin, key, node);
    if (!name) {
      throw files::ConfigError(gathered.wire_where + ": must be a string: a preset or a wire file");
    }
    gathered.wire = name->ends_with(".toml") ? (folder / *name).string() : *name;
    return true;
  };
  files::overlay(gathered.values, files::read_fields(settings_fields(), table, origin, take_wire));
}

/// The named wire with the replaced numbers; no other number follows from these.
Wire<double> wire_of(const GivenSettings& gathered, const std::string& origin) {
  files::Entries entries;
  try {
    entries = gathered.wire.empty() ? files::Entries()
                                    : files::describe_wire(files::load_wire(gathered.wire).wire);
  } catch (const files::ConfigError& error) {
    throw files::ConfigError(fmt::format("{}: {}", gathered.wire_where, error.what()));
  }
  files::overlay(entries, gathered.values);
  return files::build_wire(entries, [&](std::string_view path, const std::string& reason) {
    throw files::ConfigError(
        fmt::format("{}: {} {}; [wire] needs based_on = \"PRESET or FILE.toml\", or every number "
                    "of the wire",
                    origin, path, reason));
  });
}

/// Where the value of a parameter comes from: "FILE:LINE: KEY = VALUE", or for one that no key has
/// given, the wire or "default".
std::string origin_of(const GivenSettings& gathered, const std::string& origin, std::size_t i,
                      const Settings<double>& settings) {
  if (const auto given = gathered.values.find(slot_of(i)); given != gathered.values.end()) {
    return given->second.where;
  }
  const Row& row = parameters<double>[i];
  const bool of_wire = row.path.text().starts_with("wire.") && !gathered.wire.empty();
  return fmt::format("{}: {} = {} ({})", origin, row.path.text(),
                     value_text(row, row.get(settings)), of_wire ? gathered.wire : "default");
}

std::string contradiction(const GivenSettings& gathered, const std::string& origin,
                          const Rule& rule, const Settings<double>& settings) {
  const std::string_view a = parameters<double>[rule.a].path.text();
  const std::string_view b = parameters<double>[rule.b].path.text();
  std::string relation = fmt::format("contradicts {}", b);
  if (rule.relation == Relation::below || rule.relation == Relation::not_above) {
    std::string left = rule.factor == 1 ? std::string(a) : fmt::format("{} {}", rule.factor, a);
    if (rule.plus < parameter_count) {
      left += fmt::format(" + {}", parameters<double>[rule.plus].path.text());
    }
    relation = fmt::format("{} must {} {}", left,
                           rule.relation == Relation::below ? "be below" : "not be above", b);
  }
  return fmt::format("{}: {}: {}; {}", origin_of(gathered, origin, rule.a, settings), relation,
                     rule.meaning, origin_of(gathered, origin, rule.b, settings));
}

void require_sound(const GivenSettings& gathered, const std::string& origin,
                   const Settings<double>& settings) {
  const Finding finding = check(settings);
  if (finding.problem == Problem::contradiction) {
    throw files::ConfigError(
        contradiction(gathered, origin, parameter_rules[finding.rule], settings));
  }
  if (!finding.ok()) {
    throw files::ConfigError(fmt::format("{}: must be {}",
                                         origin_of(gathered, origin, finding.parameter, settings),
                                         range_text(parameters<double>[finding.parameter])));
  }
}

}  // namespace

Settings<double> parse_settings_file(std::string_view text, const std::string& origin,
                                     const std::vector<files::Override>& overrides,
                                     const std::filesystem::path& folder) {
  GivenSettings gathered;
  read_settings(files::parse_toml(text, origin), origin, folder, gathered);
  for (const files::Override& setting : overrides) {
    read_settings(files::parse_override(setting), std::string(files::set_origin), "", gathered);
  }
  Settings<double> settings = default_settings<double>();
  for (std::size_t i = 0; i < device_rows; ++i) {
    if (const auto given = gathered.values.find(slot_of(i)); given != gathered.values.end()) {
      const Row& row = parameters<double>[i];
      row.set(settings, value_of(row, given->second.number));
    }
  }
  settings.wire = wire_of(gathered, origin);
  settings = stored_settings<double>(settings);
  require_sound(gathered, origin, settings);
  return settings;
}

std::vector<files::Override> parse_settings(const std::vector<std::string>& texts) {
  std::vector<files::Override> settings;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw files::ConfigError(fmt::format("--set {}: must be key=value", text));
    }
    settings.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  return settings;
}

Settings<double> load_settings_file(const std::string& path,
                                    const std::vector<files::Override>& overrides) {
  return parse_settings_file(files::whole_file(path), path, overrides,
                             std::filesystem::path(path).parent_path());
}

}  // namespace smaservo::text
