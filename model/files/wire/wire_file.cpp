#include "model/files/wire/wire_file.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <optional>

#include "model/files/error.hpp"
#include "model/files/input_file.hpp"
#include "model/files/similar.hpp"
#include "model/files/toml/toml_fields.hpp"
#include "model/files/wire/presets.hpp"
#include "model/files/wire/wire_fields.hpp"

namespace smaservo::files {
namespace {

struct Loaded {
  std::string name;
  std::string origin;  ///< name of the file or text in error messages
  Entries entries;
  std::map<std::string, std::string> sources;
};

void read_sources(const toml::node& node, const std::string& origin, Loaded& loaded) {
  const toml::table* table = node.as_table();
  if (table == nullptr) {
    throw ConfigError(place(origin, "sources", node) + ": must be a table of strings");
  }
  for (const auto& [name, text] : *table) {
    const std::string key(name.str());
    if (const std::string now = renamed_key(key); !now.empty()) {
      throw ConfigError(
          fmt::format("{}: {} is now called {}", place(origin, "sources." + key, text), key, now));
    }
    loaded.sources[key] = string_of(origin, "sources." + key, text);
  }
}

/// Puts the entries of a table on top of `loaded`.
void read_wire(const toml::table& table, const std::string& origin, Loaded& loaded) {
  const auto take = [&](const std::string& key, const toml::node& node) {
    if (key == "sources") {
      read_sources(node, origin, loaded);
    }
    return key == "name" || key == "based_on" || key == "sources";
  };
  overlay(loaded.entries, read_fields(wire_fields(), table, origin, take));
}

constexpr int deepest_base = 8;

Loaded load(const std::string& name_or_path, const std::filesystem::path& folder, int depth);

/// The entries of a table on top of the description that it is based on.
Loaded resolve(const toml::table& table, const std::string& origin,
               const std::filesystem::path& folder, int depth) {
  Loaded loaded{origin, origin, {}, {}};
  if (const toml::node* sizes = table.get("sizes")) {
    throw ConfigError(place(origin, "sizes", *sizes) +
                      ": only presets have sizes; a file describes one wire");
  }
  if (const toml::node* base = table.get("based_on")) {
    const auto name = base->value<std::string>();
    if (!name) {
      throw ConfigError(place(origin, "based_on", *base) +
                        ": must be a string: a preset or a wire file");
    }
    if (depth >= deepest_base) {
      throw ConfigError(place(origin, "based_on", *base) +
                        ": the chain of based_on has more than 8 files; is it a circle?");
    }
    Loaded below = load(*name, folder, depth + 1);
    loaded.entries = std::move(below.entries);
    loaded.sources = std::move(below.sources);
  }
  if (const toml::node* name = table.get("name")) {
    loaded.name = string_of(origin, "name", *name);
  }
  read_wire(table, origin, loaded);
  return loaded;
}

std::optional<Loaded> load_preset(const std::string& name) {
  for (const Preset& preset : presets()) {
    if (!name.starts_with(preset.family)) {
      continue;
    }
    const std::string origin = fmt::format("preset {}", preset.family);
    toml::table table = parse_toml(preset.text, origin);
    const toml::table sizes = *table["sizes"].as_table();
    table.erase("sizes");
    for (const auto& [key, node] : sizes) {
      if (name == fmt::format("{}-{}", preset.family, key.str())) {
        Loaded loaded = resolve(table, origin, ".", 0);
        read_wire(*node.as_table(), origin, loaded);
        loaded.name = name;
        loaded.origin = name;
        return loaded;
      }
    }
  }
  return std::nullopt;
}

Loaded load(const std::string& name_or_path, const std::filesystem::path& folder, int depth) {
  if (name_or_path.ends_with(".toml")) {
    const std::filesystem::path file = folder / name_or_path;
    const toml::table table = parse_toml(whole_file(file.string()), file.string());
    return resolve(table, file.string(), file.parent_path(), depth);
  }
  if (auto preset = load_preset(name_or_path)) {
    return *std::move(preset);
  }
  throw ConfigError(fmt::format(
      "{}: no such wire{}; a file's name ends in .toml, the presets are: {}", name_or_path,
      did_you_mean(name_or_path, preset_names()), fmt::join(preset_names(), ", ")));
}

WireDescription finish(Loaded loaded, const std::vector<Override>& overrides) {
  for (const auto& [key, value] : overrides) {
    const toml::table table = parse_override({key, value});
    for (const char* text_key : {"name", "based_on", "sizes", "sources"}) {
      if (table.contains(text_key)) {
        throw ConfigError(fmt::format("--set {} = {}: cannot be changed by --set", key, value));
      }
    }
    const Entries above = read_fields(wire_fields(), table, std::string(set_origin));
    for (const auto& [slot, entry] : above) {
      loaded.sources[entry.field->path] = "given with --set";
    }
    overlay(loaded.entries, above);
  }
  const auto fail = [&](std::string_view path, const std::string& reason) {
    throw ConfigError(
        fmt::format("{}: {}", where_said(loaded.entries, loaded.origin, path), reason));
  };
  WireDescription description{loaded.name, build_wire(loaded.entries, fail), {}};
  check_wire(description.wire, fail);
  description.sources.assign(loaded.sources.begin(), loaded.sources.end());
  return description;
}

/// The number with the fewest digits that reads back to the same bits in this unit; nothing if it
/// would need as many digits as a double can have.
std::optional<double> short_number(const Unit& unit, double si) {
  for (int digits = 1; digits < std::numeric_limits<double>::digits10; ++digits) {
    const double value = std::stod(fmt::format("{:.{}g}", unit.from_si(si), digits));
    if (unit.to_si(value) == si) {
      return value;
    }
  }
  return std::nullopt;
}

enum class WrittenUnits : unsigned char { shortest, si };

/// "diameter_um = 76": the unit in which the number is shortest, because a value given in another
/// unit may have no short text in SI (7.599999999999999e-05 m).
std::string number_line(const Field& field, const std::string& name, double si,
                        WrittenUnits units) {
  if (units == WrittenUnits::shortest) {
    for (const KeyUnit& unit : key_units(field)) {
      if (const std::optional<double> number = short_number(unit.value, si)) {
        return fmt::format("{} = {}\n", key_with(name, unit.suffix), *number);
      }
    }
  }
  return fmt::format("{} = {}\n", key_with(name, key_units(field).front().suffix), si);
}

/// "key = value" as it stands in its table.
std::string line_of(const Field& field, const Wire<double>& wire, WrittenUnits units) {
  const std::vector<double> numbers = wire_numbers(field, wire);
  const std::string name = field.path.substr(field.path.rfind('.') + 1);
  const std::string key = key_with(name, key_units(field).front().suffix);
  if (field.type == FieldType::choice) {
    return fmt::format("{} = \"{}\"\n", key, field.choices[static_cast<std::size_t>(numbers[0])]);
  }
  if (field.type == FieldType::number) {
    return number_line(field, name, numbers[0], units);
  }
  return field.type == FieldType::polynomial
             ? fmt::format("{} = [{}]\n", key, fmt::join(numbers, ", "))
             : fmt::format("{} = {}\n", key, numbers[0]);
}

std::string written(const WireDescription& description, WrittenUnits units) {
  std::string out = fmt::format("name = {}\n", quoted(description.name));
  std::string open_table;
  for (const Field* field : written_fields(description.wire)) {
    const std::string table = field->path.substr(0, field->path.rfind('.'));
    if (table != open_table) {
      out += fmt::format("\n[{}]\n", table);
      open_table = table;
    }
    out += line_of(*field, description.wire, units);
  }
  out += "\n[sources]\n";
  for (const auto& [key, text] : description.sources) {
    out += fmt::format("{} = {}\n", quoted(key), quoted(text));
  }
  return out;
}

}  // namespace

WireDescription load_wire(const std::string& name_or_path, const std::vector<Override>& overrides) {
  return finish(load(name_or_path, "", 0), overrides);
}

WireDescription parse_wire(std::string_view text, const std::string& origin,
                           const std::vector<Override>& overrides,
                           const std::filesystem::path& folder) {
  return finish(resolve(parse_toml(text, origin), origin, folder, 0), overrides);
}

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const Preset& preset : presets()) {
    const toml::table table = parse_toml(preset.text, std::string(preset.family));
    for (const auto& [key, node] : *table["sizes"].as_table()) {
      names.push_back(fmt::format("{}-{}", preset.family, key.str()));
    }
  }
  std::ranges::sort(names);
  return names;
}

std::string to_toml(const WireDescription& description) {
  return written(description, WrittenUnits::shortest);
}

std::string to_toml_si(const WireDescription& description) {
  return written(description, WrittenUnits::si);
}

}  // namespace smaservo::files
