#include "firmware/text/settings_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <optional>
#include <sstream>
#include <toml++/toml.h>

#include "firmware/text/settings_text.hpp"
#include "model/files/error.hpp"
#include "model/files/input_file.hpp"

namespace smaservo {
namespace {

using Row = Parameter<double>;

std::string allowed_keys(const Row& row) {
  std::vector<std::string> keys;
  for (const Unit& unit : row.kind) {
    if (row.type == ValueType::real || unit.suffix.empty()) {
      keys.push_back(key_with(key_parts(row).name, unit));
    }
  }
  return fmt::format("{}", fmt::join(keys, ", "));
}

/// What a key of a file has given.
struct Given {
  Value value;
  std::string where;  ///< "FILE:LINE"
  std::string said;   ///< "KEY = VALUE"
};

struct Wanted {
  std::array<std::optional<Given>, parameter_count> values;
  std::string wire;        ///< preset, or path of a file; empty: none
  std::string wire_where;  ///< "FILE:LINE: KEY = VALUE"
};

/// One file, or one override.
class Reader {
 public:
  /// A wire file is looked for in `folder`.
  Reader(std::string origin, std::filesystem::path folder, Wanted& wanted)
      : origin_(std::move(origin)), folder_(std::move(folder)), wanted_(wanted) {}

  void read(const toml::table& table, const std::string& path = "") {
    for (const auto& [key, node] : table) {
      const std::string name(key.str());
      const std::string full = path.empty() ? name : path + "." + name;
      const toml::table* inner = node.as_table();
      if (full == "wire.based_on" || (full == "wire" && inner == nullptr)) {
        read_wire(full, node);
      } else if (inner != nullptr) {
        read(*inner, full);
      } else {
        read_value(path, name, full, node);
      }
    }
  }

 private:
  std::string where(const toml::node& node) const {
    const auto line = node.source().begin.line;
    return origin_ == "--set" ? origin_ : fmt::format("{}:{}", origin_, line);
  }
  static std::string said(const std::string& key, const toml::node& node) {
    if (node.is_floating_point()) {
      return fmt::format("{} = {}", key, node.value_or(0.0));
    }
    std::ostringstream text;
    node.visit([&](const auto& value) { text << value; });
    return fmt::format("{} = {}", key, text.str());
  }
  [[noreturn]] void fail(const std::string& key, const toml::node& node,
                         const std::string& reason) const {
    throw ConfigError(fmt::format("{}: {}: {}", where(node), said(key, node), reason));
  }

  void read_wire(const std::string& key, const toml::node& node) {
    const auto name = node.value<std::string>();
    if (!name) {
      fail(key, node, "must be a preset or a wire file");
    }
    wanted_.wire = name->ends_with(".toml") ? (folder_ / *name).string() : *name;
    wanted_.wire_where = fmt::format("{}: {}", where(node), said(key, node));
  }

  void read_value(const std::string& path, const std::string& name, const std::string& full,
                  const toml::node& node) {
    for (std::size_t i = 0; i < parameter_count; ++i) {
      const Row& row = parameters<double>[i];
      const KeyParts parts = key_parts(row);
      if (parts.table != path) {
        continue;
      }
      const auto unit = unit_of(name, parts.name, row.kind);
      if (!unit || (row.type != ValueType::real && !unit->suffix.empty())) {
        continue;
      }
      const Given given{value_of(row, *unit, full, node), where(node), said(full, node)};
      auto& slot = wanted_.values[i];
      if (slot && origin_ != "--set") {
        fail(full, node,
             fmt::format("is given twice: {}: {} already says it", slot->where, slot->said));
      }
      slot = given;
      return;
    }
    fail(full, node, unknown(path, name));
  }

  static std::string unknown(const std::string& path, const std::string& name) {
    std::vector<std::string> there;
    std::vector<std::string_view> tables;
    for (const Row& row : parameters<double>) {
      const KeyParts parts = key_parts(row);
      if (parts.table == path && name.starts_with(parts.name)) {
        return fmt::format("unknown key, or its unit is missing or unknown; allowed: {}",
                           allowed_keys(row));
      }
      if (parts.table == path) {
        there.emplace_back(key_with(parts.name, row.kind.front()));
      }
      if (tables.empty() || tables.back() != parts.table) {
        tables.push_back(parts.table);
      }
    }
    return there.empty() ? fmt::format("unknown table; the tables are: {}", fmt::join(tables, ", "))
                         : fmt::format("unknown key; [{}] has: {}", path, fmt::join(there, ", "));
  }

  Value value_of(const Row& row, const Unit& unit, const std::string& key,
                 const toml::node& node) const {
    switch (row.type) {
      case ValueType::real:
        return real_of(row, unit, key, node);
      case ValueType::number: {
        const std::int64_t whole = node.is_integer() ? node.value_or<std::int64_t>(-1) : -1;
        if (whole < row.least.number() || whole > row.greatest.number()) {
          fail(key, node, fmt::format("must be a whole number, {}", range_text(row)));
        }
        return Value::number(static_cast<std::uint32_t>(whole));
      }
      case ValueType::choice: {
        const auto word = node.value<std::string>();
        for (std::uint32_t i = 0; word && i < row.choices.size(); ++i) {
          if (row.choices[i] == *word) {
            return Value::number(i);
          }
        }
        fail(key, node, fmt::format("must be one of: {}", range_text(row)));
      }
      case ValueType::boolean:
        break;
    }
    if (!node.is_boolean()) {
      fail(key, node, "must be true or false");
    }
    return Value::number(node.value_or(false) ? 1 : 0);
  }

  Value real_of(const Row& row, const Unit& unit, const std::string& key,
                const toml::node& node) const {
    const double number =
        node.is_number() ? node.value_or(0.0) : std::numeric_limits<double>::quiet_NaN();
    if (!std::isfinite(number)) {
      fail(key, node, "must be a finite number");
    }
    constexpr auto most = static_cast<double>(std::numeric_limits<float>::max());
    const double si = std::clamp(unit.to_si(number), -most, most);
    const Value value = Value::real(static_cast<float>(si));
    if (fit(row, value) != Fit::inside) {
      const auto shown = [&](Value limit) {
        return unit.from_si(std::stod(value_text(row, limit)));
      };
      fail(key, node,
           fmt::format("must be between {:.6g} and {:.6g}{}{}", shown(row.least),
                       shown(row.greatest), unit.suffix.empty() ? "" : " ", unit.suffix));
    }
    return value;
  }

  std::string origin_;
  std::filesystem::path folder_;
  Wanted& wanted_;
};

toml::table parsed(std::string_view text, const std::string& origin) {
  try {
    return toml::parse(text, origin);
  } catch (const toml::parse_error& error) {
    throw ConfigError(fmt::format("{}:{}:{}: {}", origin, error.source().begin.line,
                                  error.source().begin.column, error.description()));
  }
}

void read_override(const Override& setting, Wanted& wanted) {
  const auto& [key, value] = setting;
  toml::table table;
  try {
    table = toml::parse(key + " = " + value);
  } catch (const toml::parse_error&) {
    table = parsed(key + " = \"" + value + "\"", "--set");
  }
  Reader("--set", "", wanted).read(table);
}

Wire<double> wire_of(const Wanted& wanted) {
  try {
    return load_wire(wanted.wire).wire;
  } catch (const WireError& error) {
    throw ConfigError(fmt::format("{}: {}", wanted.wire_where, error.what()));
  }
}

/// "FILE:LINE: KEY = VALUE", and for what no key has given, where it comes from.
std::string origin_of(const Wanted& wanted, const std::string& origin, std::size_t i,
                      const Settings<double>& settings) {
  if (const auto& given = wanted.values[i]) {
    return fmt::format("{}: {}", given->where, given->said);
  }
  const Row& row = parameters<double>[i];
  const bool of_wire = row.path.text().starts_with("wire.") && !wanted.wire.empty();
  return fmt::format("{}: {} = {} ({})", origin, row.path.text(),
                     value_text(row, row.get(settings)), of_wire ? wanted.wire : "default");
}

std::string contradiction(const Wanted& wanted, const std::string& origin, const Rule& rule,
                          const Settings<double>& settings) {
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
  return fmt::format("{}: {}: {}; {}", origin_of(wanted, origin, rule.a, settings), relation,
                     rule.meaning, origin_of(wanted, origin, rule.b, settings));
}

void require_sound(const Wanted& wanted, const std::string& origin,
                   const Settings<double>& settings) {
  if (const std::size_t missing = first_missing(settings); missing != no_parameter) {
    throw ConfigError(
        fmt::format("{}: {} is missing; [wire] needs based_on = \"PRESET or "
                    "FILE.toml\", or every number of the wire",
                    origin, parameters<double>[missing].path.text()));
  }
  const Finding finding = check(settings);
  if (finding.problem == Problem::contradiction) {
    throw ConfigError(contradiction(wanted, origin, parameter_rules[finding.rule], settings));
  }
  if (!finding.ok()) {
    throw ConfigError(fmt::format("{}: must be {}",
                                  origin_of(wanted, origin, finding.parameter, settings),
                                  range_text(parameters<double>[finding.parameter])));
  }
}

}  // namespace

Settings<double> parse_settings_file(std::string_view text, const std::string& origin,
                                     const std::vector<Override>& overrides,
                                     const std::filesystem::path& folder) {
  Wanted wanted;
  Reader(origin, folder, wanted).read(parsed(text, origin));
  for (const Override& setting : overrides) {
    read_override(setting, wanted);
  }
  Settings<double> settings = default_settings<double>();
  if (!wanted.wire.empty()) {
    settings.wire = wire_of(wanted);
    settings = stored_settings<double>(settings);
  }
  for (std::size_t i = 0; i < parameter_count; ++i) {
    if (const auto& given = wanted.values[i]) {
      parameters<double>[i].set(settings, given->value);
    }
  }
  require_sound(wanted, origin, settings);
  return settings;
}

std::vector<Override> parse_settings(const std::vector<std::string>& texts) {
  std::vector<Override> settings;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw ConfigError(fmt::format("--set {}: must be key=value", text));
    }
    settings.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  return settings;
}

Settings<double> load_settings_file(const std::string& path,
                                    const std::vector<Override>& overrides) {
  return parse_settings_file(whole_file(path), path, overrides,
                             std::filesystem::path(path).parent_path());
}

}  // namespace smaservo
