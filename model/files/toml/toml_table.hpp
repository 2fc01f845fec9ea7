#pragma once
// TOML files of scenarios, read strictly: whatever is missing, out of range or unknown is refused
// with file, line, key, value and what is allowed.

#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <toml++/toml.h>
#include <vector>

namespace smaservo::files {

/// One table of the file: its functions take keys, and finish() refuses keys that were not taken.
/// All throw ConfigError.
class TomlTable {
 public:
  /// The origin must outlive the table.
  TomlTable(const toml::table& table, std::string path, const std::string& origin)
      : table_(table), path_(std::move(path)), origin_(origin) {}

  [[noreturn]] void fail(std::string_view key, const std::string& reason) const;
  bool has(std::string_view key) const {
    known_.emplace(key);
    return table_.contains(key);
  }
  const std::string& path() const { return path_; }
  /// All keys that the file has here.
  std::vector<std::string> keys() const;

  double number(std::string_view key, double low, double high);
  double number(std::string_view key, double low, double high, double otherwise) {
    return has(key) ? number(key, low, high) : otherwise;
  }
  bool flag(std::string_view key, bool otherwise);
  std::string text(std::string_view key);
  std::vector<std::string> texts(std::string_view key);
  /// The index of the key's text among `names`.
  std::size_t choice(std::string_view key, std::span<const std::string_view> names);
  std::vector<double> numbers(std::string_view key, double low, double high);
  /// Two numbers, the first one not above the second.
  std::pair<double, double> range(std::string_view key, double low, double high);
  bool is_list(std::string_view key) const { return table_[key].is_array(); }
  bool is_table(std::string_view key) const { return table_[key].is_table(); }
  TomlTable table(std::string_view key);
  /// Like table(); an empty table if the key is missing.
  TomlTable table_or_empty(std::string_view key);
  std::vector<TomlTable> tables(std::string_view key);

  /// Refuses keys that were not asked for.
  void finish() const;

 private:
  /// Refuses the file if it has this key under its old name.
  void refuse_old_name(std::string_view key) const;
  double in_range(std::string_view key, const toml::node& node, double low, double high) const;
  const toml::node& needed(std::string_view key);

  const toml::table& table_;
  std::string path_;
  const std::string& origin_;
  std::set<std::string, std::less<>> taken_;
  /// Keys that were asked for, whether the file has them or not.
  mutable std::set<std::string, std::less<>> known_;
};

/// A whole file. Throws ConfigError.
class TomlFile {
 public:
  explicit TomlFile(const std::filesystem::path& file);
  TomlTable root() const { return {parsed_, "", origin_}; }
  const std::string& text() const { return text_; }

  /// The path of a file that the TOML file names relative to its own folder.
  std::string beside(const std::string& name) const;

 private:
  std::string origin_;
  std::string text_;
  toml::table parsed_;
};

}  // namespace smaservo::files
