#include "model/files/toml/toml_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "model/files/error.hpp"
#include "model/files/input_file.hpp"
#include "model/files/similar.hpp"
#include "model/files/toml/toml_fields.hpp"

namespace smaservo::files {

void TomlTable::fail(std::string_view key, const std::string& reason) const {
  const std::string path = path_ + std::string(key);
  const toml::node* node = table_.get(key);
  throw ConfigError(node != nullptr ? fmt::format("{}: {}", place(origin_, path, *node), reason)
                                    : fmt::format("{}:{}: {}: {}", origin_,
                                                  table_.source().begin.line, path, reason));
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> all;
  for (const auto& [key, node] : table_) {
    all.emplace_back(key.str());
  }
  return all;
}

const toml::node& TomlTable::needed(std::string_view key) {
  taken_.emplace(key);
  const toml::node* node = table_.get(key);
  if (node == nullptr) {
    refuse_old_name(key);
    fail(key, "is missing");
  }
  return *node;
}

double TomlTable::number(std::string_view key, double low, double high) {
  return in_range(key, needed(key), low, high);
}

bool TomlTable::flag(std::string_view key, bool otherwise) {
  taken_.emplace(key);
  if (!has(key)) {
    return otherwise;
  }
  const auto* const value = table_[key].as_boolean();
  if (value == nullptr) {
    fail(key, "must be true or false");
  }
  return value->get();
}

std::string TomlTable::text(std::string_view key) {
  const auto value = needed(key).value<std::string>();
  if (!value) {
    fail(key, "must be a string");
  }
  return *value;
}

std::vector<std::string> TomlTable::texts(std::string_view key) {
  const toml::array* list = needed(key).as_array();
  if (list == nullptr || !list->is_homogeneous<std::string>()) {
    fail(key, "must be a list of strings");
  }
  std::vector<std::string> all;
  for (const toml::node& node : *list) {
    all.push_back(node.as_string()->get());
  }
  return all;
}

std::size_t TomlTable::choice(std::string_view key, std::span<const std::string_view> names) {
  const std::string name = text(key);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (name == names[i]) {
      return i;
    }
  }
  fail(key, fmt::format("must be one of: {}", fmt::join(names, ", ")));
}

std::vector<double> TomlTable::numbers(std::string_view key, double low, double high) {
  const toml::array* list = needed(key).as_array();
  if (list == nullptr || list->empty()) {
    fail(key, "must be a list of numbers");
  }
  std::vector<double> all;
  for (const toml::node& node : *list) {
    all.push_back(in_range(key, node, low, high));
  }
  return all;
}

std::pair<double, double> TomlTable::range(std::string_view key, double low, double high) {
  const std::vector<double> both = numbers(key, low, high);
  if (both.size() != 2) {
    fail(key, "must be two numbers: [low, high]");
  }
  if (both[0] > both[1]) {
    fail(key, "the first number must not be above the second");
  }
  return {both[0], both[1]};
}

TomlTable TomlTable::table(std::string_view key) {
  const toml::table* inner = needed(key).as_table();
  if (inner == nullptr) {
    fail(key, "must be a table");
  }
  return {*inner, fmt::format("{}{}.", path_, key), origin_};
}

TomlTable TomlTable::table_or_empty(std::string_view key) {
  static const toml::table empty;
  return has(key) ? table(key) : TomlTable(empty, fmt::format("{}{}.", path_, key), origin_);
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) {
  taken_.emplace(key);
  const toml::array* list = table_[key].as_array();
  if (list == nullptr || list->empty() || !list->is_homogeneous<toml::table>()) {
    fail(key, fmt::format("must be one or more tables, each headed [[{}{}]]", path_, key));
  }
  std::vector<TomlTable> all;
  for (const toml::node& node : *list) {
    all.emplace_back(*node.as_table(), fmt::format("{}{}.", path_, key), origin_);
  }
  return all;
}

void TomlTable::refuse_old_name(std::string_view key) const {
  for (const auto& [given, node] : table_) {
    if (renamed_key(given.str()) == key) {
      fail(given.str(), fmt::format("is now called {}", key));
    }
  }
}

void TomlTable::finish() const {
  known_.insert(taken_.begin(), taken_.end());
  for (const std::string& key : known_) {
    refuse_old_name(key);
  }
  for (const auto& [key, node] : table_) {
    if (!taken_.contains(key.str())) {
      fail(key.str(), fmt::format("unknown key{}; allowed: {}",
                                  did_you_mean(key.str(), {known_.begin(), known_.end()}),
                                  fmt::join(known_, ", ")));
    }
  }
}

double TomlTable::in_range(std::string_view key, const toml::node& node, double low,
                           double high) const {
  const std::optional<double> value = number_of(node);
  if (!value || !(*value >= low && *value <= high)) {
    fail(key, fmt::format("must be a number between {} and {}", low, high));
  }
  return *value;
}

TomlFile::TomlFile(const std::filesystem::path& file) : origin_(file.string()) {
  text_ = whole_file(origin_);
  parsed_ = parse_toml(text_, origin_);
}

std::string TomlFile::beside(const std::string& name) const {
  return (std::filesystem::path(origin_).parent_path() / name).string();
}

}  // namespace smaservo::files
