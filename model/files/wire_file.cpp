#include "model/files/wire_file.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <optional>

#include "model/files/error.hpp"
#include "model/files/input_file.hpp"
#include "model/files/presets.hpp"
#include "model/files/toml_fields.hpp"
#include "model/files/wire_fields.hpp"

namespace smaservo {
namespace {

/// One file's share of a description.
struct Parsed {
  WireEntries entries;
  std::map<std::string, std::string> sources;
};

std::string suffixes(const WireField& field, std::string_view name) {
  std::vector<std::string> keys;
  if (field.type == WireFieldType::polynomial) {
    for (const PolynomialUnit& unit : polynomial_units(field)) {
      keys.push_back(fmt::format("{}_{}", name, unit.suffix));
    }
  } else if (field.type == WireFieldType::choice) {
    keys.emplace_back(name);
  } else {
    for (const Unit& unit : field.kind) {
      keys.push_back(unit.suffix.empty() ? std::string(name)
                                         : fmt::format("{}_{}", name, unit.suffix));
    }
  }
  return fmt::format("{}", fmt::join(keys, ", "));
}

/// "is 5 mm, must be between 0.01 and 1 mm"
std::string out_of_range(double si, double low, double high, const Unit& unit) {
  return fmt::format("must be between {:.6g} and {:.6g}{}{}, is {:.6g}", unit.from_si(low),
                     unit.from_si(high), unit.suffix.empty() ? "" : " ", unit.suffix,
                     unit.from_si(si));
}

class WireReader {
 public:
  explicit WireReader(std::string origin) : origin_(std::move(origin)) {}

  Parsed read(const toml::table& table) {
    read_table(table, "");
    return std::move(parsed_);
  }

 private:
  [[noreturn]] void fail(const std::string& key, const toml::node& node,
                         const std::string& reason) const {
    throw ConfigError(place(origin_, key, node) + ": " + reason);
  }

  void read_table(const toml::table& table, const std::string& path) {
    for (const auto& [key, node] : table) {
      const std::string name(key.str());
      const std::string full = path.empty() ? name : path + "." + name;
      if (full == "name" || full == "based_on") {
        continue;
      }
      if (full == "sources") {
        read_sources(node);
      } else if (const toml::table* inner = node.as_table()) {
        read_table(*inner, full);
      } else {
        read_value(node, path, name);
      }
    }
  }

  void read_sources(const toml::node& sources) {
    const toml::table* table = sources.as_table();
    if (table == nullptr) {
      fail("sources", sources, "must be a table of strings");
    }
    for (const auto& [key, node] : *table) {
      const auto text = node.value<std::string>();
      if (!text) {
        fail("sources." + std::string(key.str()), node, "must be a string");
      }
      parsed_.sources[std::string(key.str())] = *text;
    }
  }

  void read_value(const toml::node& node, const std::string& path, const std::string& name) {
    const std::string full = path.empty() ? name : path + "." + name;
    for (const WireField& field : wire_fields()) {
      const std::size_t dot = field.path.rfind('.');
      if (path != std::string_view(field.path).substr(0, dot)) {
        continue;
      }
      const std::string base = field.path.substr(dot + 1);
      WireEntry entry;
      if (!matches(field, base, name, node, full, entry)) {
        continue;
      }
      entry.where = place(origin_, full, node);
      if (!parsed_.entries.emplace(field.path, entry).second) {
        fail(full, node,
             fmt::format("is given twice: {} already says it", parsed_.entries[field.path].where));
      }
      return;
    }
    fail(full, node, unknown(path, name));
  }

  static std::string unknown(const std::string& path, const std::string& name) {
    for (const WireField& field : wire_fields()) {
      const std::size_t dot = field.path.rfind('.');
      const std::string base = field.path.substr(dot + 1);
      if (path == field.path.substr(0, dot) && name.starts_with(base)) {
        return fmt::format("unknown key or unit; allowed: {}", suffixes(field, base));
      }
    }
    std::vector<std::string> there;
    for (const WireField& field : wire_fields()) {
      const std::size_t dot = field.path.rfind('.');
      if (path == field.path.substr(0, dot)) {
        there.push_back(field.path.substr(dot + 1));
      }
    }
    return there.empty() ? "unknown table"
                         : fmt::format("unknown key; [{}] has: {}", path, fmt::join(there, ", "));
  }

  /// Whether the key names this field; fills the entry. Throws when it does and the value is bad.
  bool matches(const WireField& field, const std::string& base, const std::string& name,
               const toml::node& node, const std::string& full, WireEntry& entry) const {
    switch (field.type) {
      case WireFieldType::choice:
        if (name != base) {
          return false;
        }
        read_choice(field, node, full, entry);
        return true;
      case WireFieldType::number:
        if (const auto unit = unit_of(name, base, field.kind)) {
          const double si = unit->to_si(number(node, full));
          if (!(si >= field.low && si <= field.high)) {
            fail(full, node, out_of_range(si, field.low, field.high, *unit));
          }
          entry.numbers = {si};
          return true;
        }
        return false;
      case WireFieldType::polynomial:
        for (const PolynomialUnit& unit : polynomial_units(field)) {
          if (name == base + "_" + unit.suffix) {
            read_polynomial(field, unit, node, full, entry);
            return true;
          }
        }
        return false;
    }
    return false;
  }

  void read_choice(const WireField& field, const toml::node& node, const std::string& full,
                   WireEntry& entry) const {
    const auto word = node.value<std::string>();
    if (!word || std::ranges::find(field.choices, *word) == field.choices.end()) {
      fail(full, node, fmt::format("must be one of: {}", fmt::join(field.choices, ", ")));
    }
    entry.word = *word;
  }

  double number(const toml::node& node, const std::string& full) const {
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value || !std::isfinite(*value)) {
      fail(full, node, "must be a finite number");
    }
    return *value;
  }

  void read_polynomial(const WireField& field, const PolynomialUnit& unit, const toml::node& node,
                       const std::string& full, WireEntry& entry) const {
    const toml::array* list = node.as_array();
    if (list == nullptr || list->empty() || list->size() > field.coefficients) {
      fail(full, node,
           fmt::format("must be a list of 1 to {} coefficients by power of the stress",
                       field.coefficients));
    }
    double scale = 1;
    for (const toml::node& item : *list) {
      const double value = number(item, full);
      entry.numbers.push_back(entry.numbers.empty() ? unit.value.to_si(value)
                                                    : value * unit.value.factor * scale);
      scale /= unit.stress_Pa;
    }
    if (!(entry.numbers[0] >= field.low && entry.numbers[0] <= field.high)) {
      fail(full, node,
           "at zero stress " + out_of_range(entry.numbers[0], field.low, field.high, unit.value));
    }
  }

  std::string origin_;
  Parsed parsed_;
};

/// Puts `above` on top of `below`.
void overlay(Parsed& below, Parsed above) {
  for (auto& [path, entry] : above.entries) {
    below.entries[path] = std::move(entry);
  }
  for (auto& [key, text] : above.sources) {
    below.sources[key] = std::move(text);
  }
}

struct Loaded {
  std::string name;
  std::string origin;  ///< what error messages call it
  Parsed parsed;
};

constexpr int deepest_base = 8;

Loaded load(const std::string& name_or_path, const std::filesystem::path& folder, int depth);

/// A table with what it is based on beneath it.
Loaded resolve(const toml::table& table, const std::string& origin,
               const std::filesystem::path& folder, int depth) {
  Loaded loaded{origin, origin, {}};
  if (const toml::node* sizes = table.get("sizes")) {
    throw ConfigError(place(origin, "sizes", *sizes) +
                      ": only presets have sizes; a file describes one wire");
  }
  if (const toml::node* base = table.get("based_on")) {
    const auto name = base->value<std::string>();
    if (!name) {
      throw ConfigError(place(origin, "based_on", *base) + ": must be a preset or a file");
    }
    if (depth >= deepest_base) {
      throw ConfigError(place(origin, "based_on", *base) +
                        ": too many files are based on each other; is there a circle?");
    }
    loaded.parsed = load(*name, folder, depth + 1).parsed;
  }
  if (const toml::node* name = table.get("name")) {
    loaded.name = string_of(origin, "name", *name);
  }
  overlay(loaded.parsed, WireReader(origin).read(table));
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
        overlay(loaded.parsed, WireReader(origin).read(*node.as_table()));
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
  throw ConfigError(
      fmt::format("{}: no such wire; a file's name ends in .toml, the presets are: {}",
                  name_or_path, fmt::join(preset_names(), ", ")));
}

WireDescription finish(Loaded loaded, const std::vector<Override>& overrides) {
  for (const auto& [key, value] : overrides) {
    const toml::table table = parse_override({key, value});
    for (const char* text_key : {"name", "based_on", "sizes", "sources"}) {
      if (table.contains(text_key)) {
        throw ConfigError(fmt::format("--set {} = {}: cannot be set", key, value));
      }
    }
    Parsed above = WireReader("--set").read(table);
    for (const auto& [path, entry] : above.entries) {
      above.sources[path] = "given with --set";
    }
    overlay(loaded.parsed, std::move(above));
  }
  const auto fail = [&](std::string_view path, const std::string& reason) {
    const auto it = loaded.parsed.entries.find(path);
    throw ConfigError(it == loaded.parsed.entries.end()
                          ? fmt::format("{}: {}: {}", loaded.origin, path, reason)
                          : fmt::format("{}: {}", it->second.where, reason));
  };
  WireDescription description{loaded.name, build_wire(loaded.parsed.entries, fail), {}};
  description.sources.assign(loaded.parsed.sources.begin(), loaded.parsed.sources.end());
  return description;
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
  // Ordered as the fields are; TOML wants the tables one after the other.
  const WireEntries entries = describe_wire(description.wire);
  std::string out = fmt::format("name = {}\n", quoted(description.name));
  std::string open_table;
  for (const WireField& field : wire_fields()) {
    const auto it = entries.find(field.path);
    if (it == entries.end()) {
      continue;
    }
    const std::size_t dot = field.path.rfind('.');
    const std::string table = field.path.substr(0, dot);
    const std::string base = field.path.substr(dot + 1);
    if (table != open_table) {
      out += fmt::format("\n[{}]\n", table);
      open_table = table;
    }
    const WireEntry& entry = it->second;
    if (field.type == WireFieldType::choice) {
      out += fmt::format("{} = \"{}\"\n", base, entry.word);
    } else if (field.type == WireFieldType::polynomial) {
      out += fmt::format("{}_{} = [{}]\n", base, polynomial_units(field).front().suffix,
                         fmt::join(entry.numbers, ", "));
    } else {
      const std::string_view suffix = field.kind.front().suffix;
      out += fmt::format("{}{}{} = {}\n", base, suffix.empty() ? "" : "_", suffix,
                         entry.numbers.front());
    }
  }
  out += "\n[sources]\n";
  for (const auto& [key, text] : description.sources) {
    out += fmt::format("{} = {}\n", quoted(key), quoted(text));
  }
  return out;
}

}  // namespace smaservo
