#include "model/files/toml/toml_fields.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <sstream>

#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/similar.hpp"

namespace smaservo::files {
namespace {

/// The text of a node as TOML writes it.
std::string written(const toml::node& node) {
  if (node.is_floating_point()) {
    return fmt::format("{}", node.value_or(0.0));  // "1e-09", not "1.0000000000000001e-09"
  }
  std::ostringstream out;
  node.visit([&](const auto& value) { out << value; });
  return out.str();
}

std::string_view table_of(std::string_view path) {
  return path.substr(0, std::min(path.rfind('.'), path.size()));
}
std::string_view name_of(std::string_view path) {
  return path.substr(path.rfind('.') + 1);
}

/// Compares at the precision of a device, which stores floats.
bool in_range(const Field& field, double si) {
  constexpr auto max = static_cast<double>(std::numeric_limits<float>::max());
  const auto rounded = [&](double x) { return static_cast<float>(std::clamp(x, -max, max)); };
  return rounded(field.min) <= rounded(si) && rounded(si) <= rounded(field.max);
}

/// The field whose name is the longest beginning of this key, written with each of its units.
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

/// The field that has this key, and the unit that the key ends in.
std::optional<std::pair<const Field*, KeyUnit>> find_field(std::span<const Field> fields,
                                                           std::string_view key) {
  for (const Field& field : fields) {
    if (!key.starts_with(field.path)) {
      continue;
    }
    for (const KeyUnit& unit : key_units(field)) {
      if (key == key_with(field.path, unit.suffix)) {
        return std::pair(&field, unit);
      }
    }
  }
  return std::nullopt;
}

/// The new name of an old key; empty if it is no old key, if `fields` lack the new one, or if a
/// renamed table still exists in `fields` under the old name.
std::string new_key(std::span<const Field> fields, std::string_view key) {
  const std::string now = renamed_key(key);
  const bool has_table = std::ranges::any_of(
      fields, [&](const Field& field) { return table_of(field.path) == table_of(key); });
  const bool moved = table_of(now) != table_of(key);
  return find_field(fields, now) && !(moved && has_table) ? now : "";
}

std::string unknown_key(std::span<const Field> fields, const std::string& key) {
  if (const std::string now = new_key(fields, key); !now.empty()) {
    return fmt::format("is now called {}", now);
  }
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
  if (there.empty()) {
    return fmt::format("unknown table{}; the tables are: {}",
                       did_you_mean(table_of(key), {tables.begin(), tables.end()}),
                       fmt::join(tables, ", "));
  }
  return fmt::format("unknown key{}; [{}] has: {}", did_you_mean(name_of(key), there),
                     table_of(key), fmt::join(there, ", "));
}

/// The value that a file gives to one key.
class KeyValue {
 public:
  KeyValue(const Field& field, const KeyUnit& unit, const toml::node& node,
           const std::string& where)
      : field_(field), unit_(unit), node_(node), where_(where) {}

  std::vector<double> numbers() const {
    switch (field_.type) {
      case FieldType::number:
        return {ranged(number(node_))};
      case FieldType::list:
        return list();
      case FieldType::polynomial:
        return polynomial();
      case FieldType::whole:
        return {whole()};
      case FieldType::choice:
        return {choice()};
      case FieldType::flag:
        break;
    }
    if (!node_.is_boolean()) {
      fail("must be true or false");
    }
    return {node_.value_or(false) ? 1.0 : 0.0};
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw ConfigError(fmt::format("{}: {}", where_, reason));
  }

  double number(const toml::node& item) const {
    const std::optional<double> value = number_of(item);
    if (!value) {
      fail("must be a finite number");
    }
    return *value;
  }

  double ranged(double value) const {
    const Unit& unit = unit_.value;
    const double si = unit.to_si(value);
    if (!in_range(field_, si)) {
      fail(fmt::format("{}must be between {:.6g} and {:.6g}{}{}, is {:.6g}",
                       field_.type == FieldType::polynomial ? "at zero stress " : "",
                       unit.from_si(field_.min), unit.from_si(field_.max),
                       unit.suffix.empty() ? "" : " ", unit.suffix, value));
    }
    return si;
  }

  std::vector<double> list() const {
    const toml::array* items = node_.as_array();
    if (items == nullptr || items->size() != field_.count) {
      fail(fmt::format("must be a list of {} numbers", field_.count));
    }
    std::vector<double> all;
    for (const toml::node& item : *items) {
      all.push_back(ranged(number(item)));
    }
    return all;
  }

  std::vector<double> polynomial() const {
    const toml::array* items = node_.as_array();
    if (items == nullptr || items->empty() || items->size() > field_.count) {
      fail(fmt::format("must be a list of 1 to {} coefficients by power of the stress",
                       field_.count));
    }
    std::vector<double> all;
    double scale = 1;
    for (const toml::node& item : *items) {
      all.push_back(number(item) * unit_.value.factor * scale);
      scale /= unit_.stress_Pa;
    }
    all.front() = ranged(number(items->front()));
    all.resize(field_.count);
    return all;
  }

  double whole() const {
    const auto value = static_cast<double>(node_.value_or(std::int64_t{-1}));
    if (!node_.is_integer() || !(field_.min <= value && value <= field_.max)) {
      fail(fmt::format("must be a whole number, {} to {}", field_.min, field_.max));
    }
    return value;
  }

  double choice() const {
    const auto word = node_.value<std::string>();
    const auto at = std::ranges::find(field_.choices, word.value_or(""));
    if (!word || at == field_.choices.end()) {
      fail(fmt::format("must be one of: {}", fmt::join(field_.choices, ", ")));
    }
    return static_cast<double>(at - field_.choices.begin());
  }

  const Field& field_;
  const KeyUnit& unit_;
  const toml::node& node_;
  const std::string& where_;
};

void enter(std::span<const Field> fields, const std::string& key, const std::string& where,
           const toml::node& node, Entries& entries) {
  const auto found = find_field(fields, key);
  if (!found) {
    throw ConfigError(fmt::format("{}: {}", where, unknown_key(fields, key)));
  }
  const auto& [field, unit] = *found;
  std::size_t slot = field->slot;
  for (const double number : KeyValue(*field, unit, node, where).numbers()) {
    const auto [at, is_new] = entries.try_emplace(slot++, number, field, where);
    if (!is_new) {
      throw ConfigError(fmt::format("{}: is given twice, first by {}", where, at->second.where));
    }
  }
}

void enter_table(std::span<const Field> fields, const toml::table& table, const std::string& path,
                 const std::string& origin, const OtherKeys& other, Entries& entries) {
  for (const auto& [name, node] : table) {
    const std::string key = path + std::string(name.str());
    const toml::table* inner = node.as_table();
    if (other && other(key, node)) {
      continue;
    }
    if (inner != nullptr) {
      enter_table(fields, *inner, key + ".", origin, other, entries);
    } else {
      enter(fields, key, place(origin, key, node), node, entries);
    }
  }
}

}  // namespace

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
  const std::string line = origin == set_origin ? "" : fmt::format(":{}", node.source().begin.line);
  return fmt::format("{}{}: {} = {}", origin, line, key, written(node));
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
  std::string out;
  for (const char c : text) {
    out.append(c == '"' || c == '\\' ? "\\" : "").append(1, c);
  }
  return '"' + printable_toml(out) + '"';
}

Entries read_fields(std::span<const Field> fields, const toml::table& table,
                    const std::string& origin, const OtherKeys& other) {
  Entries entries;
  enter_table(fields, table, "", origin, other, entries);
  return entries;
}

void overlay(Entries& below, const Entries& above) {
  for (const auto& [slot, entry] : above) {
    below[slot] = entry;
  }
}

}  // namespace smaservo::files
