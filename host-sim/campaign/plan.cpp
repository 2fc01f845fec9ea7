#include "host-sim/campaign/plan.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sstream>

#include "host-sim/hash.hpp"
#include "model/files/error.hpp"
#include "model/files/input_file.hpp"
#include "model/files/toml/toml_fields.hpp"

namespace smaservo::campaign {
namespace {

constexpr double most_trials = 1e9;
/// Rows of a chunk are in memory until it is written.
constexpr double most_in_a_chunk = 1e6;
/// Greatest seed: a number of a TOML file that is exact as a double.
constexpr double greatest_seed = 1e15;
/// How long a chunk takes if the plan does not say how large it is.
constexpr double chunk_s = 180;
constexpr std::string_view file_mark = "file ";

std::uint64_t whole_number(files::TomlTable& table, std::string_view key, double low, double high) {
  const double number = table.number(key, low, high);
  if (number != std::floor(number)) {
    table.fail(key, "must be a whole number");
  }
  return static_cast<std::uint64_t>(number);
}

std::string one_line(const toml::node& node) {
  std::ostringstream text;
  node.visit([&](const auto& value) { text << toml::toml_formatter(value); });
  std::string line = text.str();
  std::ranges::replace(line, '\n', ' ');
  return line;
}

/// The keys of a table in the order of their names, whatever the file's layout and comments are.
void add_keys(Identity& identity, const toml::table& table, const std::string& before) {
  for (const auto& [key, node] : table) {
    const std::string path = before + std::string(key.str());
    if (const toml::table* inner = node.as_table()) {
      add_keys(identity, *inner, path + '.');
    } else if (path != "chunk") {
      identity.emplace_back(path, one_line(node));
    }
  }
}

std::uint64_t chunk_size(files::TomlTable& root, const Plan& plan, const Trials& trials) {
  const std::uint64_t given =
      root.has("chunk") ? whole_number(root, "chunk", 0, most_in_a_chunk) : 0;
  if (given > plan.trials) {
    root.fail("chunk", fmt::format("must not be above trials, {}", plan.trials));
  }
  if (given > 0) {
    return given;
  }
  const double wanted = std::clamp(std::floor(chunk_s / trials.cost_s()), 1.0, most_in_a_chunk);
  return std::min(plan.trials, static_cast<std::uint64_t>(wanted));
}

/// Of a kind whose files say how many trials there are, `found`; 0: of another kind.
void take_trials(files::TomlTable& root, Plan& plan, std::uint64_t found) {
  if (found == 0 && plan.trials == 0) {
    whole_number(root, "trials", 1, most_trials);  // says that it is missing
  }
  if (found > 0 && plan.trials > found) {
    root.fail("trials", fmt::format("must not be above {}, as many as there are", found));
  }
  plan.trials = plan.trials == 0 ? found : plan.trials;
}

std::string_view value_in(const Identity& identity, std::string_view name) {
  const auto found = std::ranges::find(identity, name, &Identity::value_type::first);
  return found == identity.end() ? std::string_view() : std::string_view(found->second);
}

}  // namespace

std::uint64_t KindTable::whole(std::string_view key, double low, double high, double otherwise) {
  return table_.has(key) ? whole_number(table_, key, low, high)
                         : static_cast<std::uint64_t>(otherwise);
}

std::string KindTable::path(std::string_view key) {
  return file_.beside(table_.text(key));
}

std::string KindTable::depends_on(std::string_view key, const std::string& name,
                                  const std::string& path) {
  try {
    depends_on_text(name, files::whole_file(path));
    return found_.back().second;
  } catch (const files::ConfigError& error) {
    table_.fail(key, error.what());
  }
}

void KindTable::depends_on_text(const std::string& name, std::string_view text) {
  found_.emplace_back(std::string(file_mark) + files::quoted(name), hash_of(text));
}

std::string program_version() {
  return SMASERVO_VERSION;
}

Campaign read_plan(const std::string& path, std::span<const Kind> kinds,
                   const std::string& version) {
  const files::TomlFile file(path);
  files::TomlTable root = file.root();
  Plan plan{};
  plan.path = path;
  plan.text = file.text();
  plan.version = version;
  std::vector<std::string_view> names;
  names.reserve(kinds.size());
  for (const Kind& kind : kinds) {
    names.push_back(kind.name);
  }
  const Kind& kind = kinds[root.choice("kind", names)];
  plan.kind = kind.name;
  plan.trials = root.has("trials") ? whole_number(root, "trials", 1, most_trials) : 0;
  plan.seed = root.has("seed") ? whole_number(root, "seed", 0, greatest_seed) : 0;
  files::TomlTable keys = root.table(kind.name);
  Identity found;
  KindTable table(plan, file, keys, found);
  std::unique_ptr<const Trials> trials = kind.read(table);
  keys.finish();
  take_trials(root, plan, table.trials());
  plan.chunk = chunk_size(root, plan, *trials);
  root.finish();
  plan.identity = {{"version", plan.version}, {"chunk", fmt::to_string(plan.chunk)}};
  add_keys(plan.identity, files::parse_toml(plan.text, path), "");
  plan.identity.insert(plan.identity.end(), found.begin(), found.end());
  Hash hash;
  for (const auto& [name, value] : plan.identity) {
    hash.add(fmt::format("{} = {}\n", name, value));
  }
  plan.fingerprint = hash.hex();
  return {std::move(plan), std::move(trials)};
}

std::string some_of(const std::vector<std::string>& all, std::string_view separator) {
  constexpr std::size_t most_named = 8;
  const std::span named(all.data(), std::min(most_named, all.size()));
  return fmt::format(
      "{}{}", fmt::join(named, separator),
      all.size() > most_named ? fmt::format(" and {} more", all.size() - most_named) : "");
}

std::string differences(const Identity& there, const Identity& here) {
  std::vector<std::string> all;
  for (const auto& [name, value] : here) {
    const std::string_view other = value_in(there, name);
    if (other != value) {
      const bool file = name.starts_with(file_mark);
      all.push_back(file && other.empty() ? fmt::format("{} is not in the folder's plan", name)
                    : file                ? fmt::format("{} has another content", name)
                                          : fmt::format("{} is {} in the folder, {} here", name,
                                         other.empty() ? "not given" : other, value));
    }
  }
  for (const auto& [name, value] : there) {
    if (value_in(here, name).empty()) {
      all.push_back(fmt::format("{} is given in the folder, not here", name));
    }
  }
  return some_of(all, "; ");
}

std::string identity_text(const Plan& plan) {
  std::string text = "# What the rows depend on; written by host-sim campaign.\n";
  for (const auto& [name, value] : plan.identity) {
    text += fmt::format("{} = {}\n", name, value);
  }
  return text;
}

Identity identity_of(std::string_view text) {
  Identity identity;
  std::istringstream lines{std::string(text)};
  for (std::string line; std::getline(lines, line);) {
    const std::size_t middle = line.find(" = ");
    if (!line.starts_with('#') && middle != std::string::npos) {
      identity.emplace_back(line.substr(0, middle), line.substr(middle + 3));
    }
  }
  return identity;
}

}  // namespace smaservo::campaign
