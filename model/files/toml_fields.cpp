#include "model/files/toml_fields.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <sstream>

#include "model/files/error.hpp"

namespace smaservo {
namespace {

std::string_view table_of(std::string_view path) {
  return path.substr(0, std::min(path.rfind('.'), path.size()));
}
std::string_view name_of(std::string_view path) {
  return path.substr(path.rfind('.') + 1);
}

/// To the precision of a device, which keeps floats.
bool in_range(const Field& field, double si) {
  constexpr auto most = static_cast<double>(std::numeric_limits<float>::max());
  const auto rounded = [&](double x) { return static_cast<float>(std::clamp(x, -most, most)); };
  return rounded(field.min) <= rounded(si) && rounded(si) <= rounded(field.max);
}

/// The key with the longest name that this one begins with, in all its units.
std::vector<std::string> meant_keys(std::span<const Field> fields, const std::string& key) {
  std::vector<std::string> keys;
  std::string_view longest;
  for (const Field& field : fields) {
    const bool begins =
        table_of(field.path) == table_of(key) && (key + "_").starts_with(field.path + "_");
    if (!begins || field.path.size() < longest.size()) {
      continue;
    }
    if (field.path != longest) {
      keys.clear();
    }
    longest = field.path;
    for (const KeyUnit& unit : key_units(field)) {
      keys.push_back(key_with(name_of(field.path), unit.suffix));
    }
  }
  return keys;
}

std::string unknown_key(std::span<const Field> fields, const std::string& key) {
  const std::vector<std::string> meant = meant_keys(fields, key);
  if (!meant.empty()) {
    return fmt::format("unknown key or unit; allowed: {}", fmt::join(meant, ", "));
  }
  std::vector<std::string> there;
  std::vector<std::string_view> tables;
  const bool in_table = key.find('.') != std::string::npos;
  for (const Field& field : fields) {
    const std::string_view table = table_of(field.path);
    if (in_table && table == table_of(key)) {
      there.push_back(key_with(name_of(field.path), key_units(field).front().suffix));
    }
    if (std::ranges::find(tables, table) == tables.end()) {
      tables.push_back(table);
    }
  }
  return there.empty()
             ? fmt::format("unknown table; the tables are: {}", fmt::join(tables, ", "))
             : fmt::format("unknown key; [{}] has: {}", table_of(key), fmt::join(there, ", "));
}

/// One file, or one override.
class Reader {
 public:
  Reader(std::span<const Field> fields, const std::string& origin, const OtherKeys& other)
      : fields_(fields), origin_(origin), other_(other) {}

  void read(const toml::table& table, const std::string& path) {
    for (const auto& [name, node] : table) {
      const std::string key = path + std::string(name.str());
      if (other_ && other_(key, node)) {
        continue;
      }
      if (const toml::table* inner = node.as_table()) {
        read(*inner, key + ".");
      } else {
        read_value(key, node);
      }
    }
  }

  Entries entries;

 private:
  [[noreturn]] void fail(const std::string& key, const toml::node& node,
                         const std::string& reason) const {
    throw ConfigError(fmt::format("{}: {}", place(origin_, key, node), reason));
  }

  void read_value(const std::string& key, const toml::node& node) {
    for (const Field& field : fields_) {
      if (!key.starts_with(field.path)) {
        continue;
      }
      for (const KeyUnit& unit : key_units(field)) {
        if (key == key_with(field.path, unit.suffix)) {
          enter(field, numbers(field, unit, key, node), key, node);
          return;
        }
      }
    }
    fail(key, node, unknown_key(fields_, key));
  }

  void enter(const Field& field, const std::vector<double>& numbers, const std::string& key,
             const toml::node& node) {
    const std::string where = place(origin_, key, node);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const auto [at, is_new] = entries.try_emplace(field.slot + i, numbers[i], &field, where);
      if (!is_new) {
        fail(key, node, fmt::format("is given twice: {} already says it", at->second.where));
      }
    }
  }

  std::vector<double> numbers(const Field& field, const KeyUnit& unit, const std::string& key,
                              const toml::node& node) const {
    switch (field.type) {
      case FieldType::number:
        return {ranged(field, unit, number(key, node, node), key, node)};
      case FieldType::list:
        return list(field, unit, key, node);
      case FieldType::polynomial:
        return polynomial(field, unit, key, node);
      case FieldType::whole:
        return {whole(field, key, node)};
      case FieldType::choice:
        return {choice(field, key, node)};
      case FieldType::flag:
        break;
    }
    if (!node.is_boolean()) {
      fail(key, node, "must be true or false");
    }
    return {node.value_or(false) ? 1.0 : 0.0};
  }

  /// An item of the node, or the node itself.
  double number(const std::string& key, const toml::node& item, const toml::node& node) const {
    const std::optional<double> value = number_of(item);
    if (!value) {
      fail(key, node, "must be a finite number");
    }
    return *value;
  }

  double ranged(const Field& field, const KeyUnit& unit, double value, const std::string& key,
                const toml::node& node) const {
    const double si = unit.value.to_si(value);
    if (!in_range(field, si)) {
      const std::string_view suffix = unit.value.suffix;
      fail(key, node,
           fmt::format("{}must be between {:.6g} and {:.6g}{}{}, is {:.6g}",
                       field.type == FieldType::polynomial ? "at zero stress " : "",
                       unit.value.from_si(field.min), unit.value.from_si(field.max),
                       suffix.empty() ? "" : " ", suffix, value));
    }
    return si;
  }

  std::vector<double> list(const Field& field, const KeyUnit& unit, const std::string& key,
                           const toml::node& node) const {
    const toml::array* items = node.as_array();
    if (items == nullptr || items->size() != field.count) {
      fail(key, node, fmt::format("must be a list of {} numbers", field.count));
    }
    std::vector<double> all;
    for (const toml::node& item : *items) {
      all.push_back(ranged(field, unit, number(key, item, node), key, node));
    }
    return all;
  }

  std::vector<double> polynomial(const Field& field, const KeyUnit& unit, const std::string& key,
                                 const toml::node& node) const {
    const toml::array* items = node.as_array();
    if (items == nullptr || items->empty() || items->size() > field.count) {
      fail(key, node,
           fmt::format("must be a list of 1 to {} coefficients by power of the stress",
                       field.count));
    }
    std::vector<double> all;
    double scale = 1;
    for (const toml::node& item : *items) {
      const double value = number(key, item, node);
      all.push_back(all.empty() ? ranged(field, unit, value, key, node)
                                : value * unit.value.factor * scale);
      scale /= unit.stress_Pa;
    }
    all.resize(field.count);
    return all;
  }

  double whole(const Field& field, const std::string& key, const toml::node& node) const {
    const auto value = static_cast<double>(node.value_or(std::int64_t{-1}));
    if (!node.is_integer() || !(field.min <= value && value <= field.max)) {
      fail(key, node, fmt::format("must be a whole number, {} to {}", field.min, field.max));
    }
    return value;
  }

  double choice(const Field& field, const std::string& key, const toml::node& node) const {
    const auto word = node.value<std::string>();
    const auto at = std::ranges::find(field.choices, word.value_or(""));
    if (!word || at == field.choices.end()) {
      fail(key, node, fmt::format("must be one of: {}", fmt::join(field.choices, ", ")));
    }
    return static_cast<double>(at - field.choices.begin());
  }

  std::span<const Field> fields_;
  const std::string& origin_;
  const OtherKeys& other_;
};

}  // namespace

std::string key_with(std::string_view name, std::string_view suffix) {
  return suffix.empty() ? std::string(name) : fmt::format("{}_{}", name, suffix);
}

std::vector<KeyUnit> key_units(const Field& field) {
  std::vector<KeyUnit> units;
  for (const Unit& value : field.kind) {
    const std::string suffix(value.suffix);
    if (field.type != FieldType::polynomial) {
      units.push_back({suffix, value});
      continue;
    }
    for (const Unit& stress : {kind::stress[0], kind::stress[2]}) {
      const std::string prefix = suffix.empty() ? "" : suffix + "_";
      units.push_back({prefix + "by_" + std::string(stress.suffix), value, stress.factor});
    }
  }
  return units;
}

toml::table parse_toml(std::string_view text, const std::string& origin) {
  try {
    return toml::parse(text, origin);
  } catch (const toml::parse_error& error) {
    throw ConfigError(fmt::format("{}:{}:{}: {}", origin, error.source().begin.line,
                                  error.source().begin.column, error.description()));
  }
}

toml::table parse_override(const Override& setting) {
  const auto& [key, value] = setting;
  try {
    return toml::parse(fmt::format("{} = {}", key, value));
  } catch (const toml::parse_error&) {
    return parse_toml(fmt::format("{} = \"{}\"", key, value), std::string(set_origin));
  }
}

std::string place(const std::string& origin, const std::string& key, const toml::node& node) {
  std::ostringstream value;
  node.visit([&](const auto& item) { value << item; });
  const auto line = node.source().begin.line;
  return origin == set_origin ? fmt::format("{}: {} = {}", origin, key, value.str())
                              : fmt::format("{}:{}: {} = {}", origin, line, key, value.str());
}

std::optional<double> number_of(const toml::node& node) {
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::string string_of(const std::string& origin, const std::string& key, const toml::node& node) {
  const auto text = node.value<std::string>();
  if (!text) {
    throw ConfigError(place(origin, key, node) + ": must be a string");
  }
  return *text;
}

std::string quoted(const std::string& text) {
  std::ostringstream out;
  out << toml::value<std::string>(text);
  return out.str();
}

Entries read_fields(std::span<const Field> fields, const toml::table& table,
                    const std::string& origin, const OtherKeys& other) {
  Reader reader(fields, origin, other);
  reader.read(table, "");
  return std::move(reader.entries);
}

void overlay(Entries& below, const Entries& above) {
  for (const auto& [slot, entry] : above) {
    below[slot] = entry;
  }
}

}  // namespace smaservo
