#include "host-sim/replay/ci/expectations.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "model/files/error.hpp"
#include "model/files/toml/toml_fields.hpp"
#include "model/files/toml/toml_table.hpp"

namespace smaservo::replay {
namespace {

constexpr const char* default_table = "default";
/// Within a table of a trace: bounds of columns of the estimate.
constexpr const char* estimate_table = "estimate";
/// The observer of a trace of temperatures, of which there is no choice.
constexpr const char* model_alone = "model";

std::string file_name(const std::string& trace) {
  return std::filesystem::path(trace).filename().string();
}

std::optional<double> percent(files::TomlTable& table, const char* key) {
  return table.has(key) ? std::optional(table.number(key, 0, highest_bound_percent)) : std::nullopt;
}

std::optional<std::uint64_t> count(files::TomlTable& table, const char* key, double least) {
  if (!table.has(key)) {
    return std::nullopt;
  }
  const double number = table.number(key, least, 1e15);
  if (number != std::floor(number)) {
    table.fail(key, "must be a whole number");
  }
  return static_cast<std::uint64_t>(number);
}

std::optional<double> any_number(files::TomlTable& table, const char* key) {
  return table.has(key) ? std::optional(table.number(key, -1e9, 1e9)) : std::nullopt;
}

ColumnBounds read_column(files::TomlTable table) {
  ColumnBounds bounds{any_number(table, "min"), any_number(table, "max"), any_number(table, "mean"),
                      0};
  if (bounds.mean) {
    bounds.tolerance = table.number("tolerance", 0, 1e9);
  } else if (table.has("tolerance")) {
    table.fail("tolerance", "is that of mean, which is not given");
  }
  if (bounds.min && bounds.max && *bounds.min > *bounds.max) {
    table.fail("min", "must not be above max");
  }
  table.finish();
  return bounds;
}

void read_estimate(files::TomlTable table, Bounds& bounds) {
  for (std::size_t i = 0; i < summarized_columns.size(); ++i) {
    if (table.has(summarized_columns[i])) {
      bounds.columns[i] = read_column(table.table(summarized_columns[i]));
    }
  }
  table.finish();
}

Bounds read_bounds(files::TomlTable table, const std::string& given_by,
                   std::span<const std::string> observers) {
  for (const std::string& key : table.keys()) {
    if (key != estimate_table && table.is_table(key)) {
      table.fail(key,
                 "is a table in a table; the name of a file with a dot needs quotes, as "
                 "[\"run.csv\"]");
    }
  }
  Bounds bounds;
  bounds.given_by = given_by;
  bounds.mean_percent = percent(table, "mean");
  bounds.p95_percent = percent(table, "p95");
  bounds.max_percent = percent(table, "max");
  bounds.rows = count(table, "rows", 1);
  bounds.max_skipped = count(table, "max_skipped", 0);
  bounds.max_invalid = count(table, "max_invalid", 0);
  if (table.has("observer")) {
    bounds.observer = table.text("observer");
    if (bounds.observer != model_alone &&
        std::ranges::find(observers, bounds.observer) == observers.end()) {
      table.fail("observer", fmt::format("is not one of those that run: {}, or {} for traces of "
                                         "temperature and stress",
                                         fmt::join(observers, ", "), model_alone));
    }
  }
  if (table.has(estimate_table)) {
    read_estimate(table.table(estimate_table), bounds);
  }
  table.finish();
  return bounds;
}

}  // namespace

Expectations::Expectations(const std::string& file, std::span<const std::string> traces,
                           std::span<const std::string> observers) {
  const files::TomlFile toml(file);
  files::TomlTable root = toml.root();
  for (const std::string& name : root.keys()) {
    if (!root.is_table(name)) {
      root.fail(name,
                "stands in no table; begin one with [default] or with the name of a trace, as "
                "[\"run.csv\"]");
    }
    const std::string table = name == default_table ? name : files::quoted(name);
    by_name_[name] = read_bounds(root.table(name), fmt::format("{}: [{}]", file, table), observers);
    if (name != default_table && std::ranges::find(traces, name, file_name) == traces.end()) {
      root.fail(name, "no trace of this name is given, so these bounds would never be judged");
    }
  }
  for (const std::string& trace : traces) {
    const std::string name = file_name(trace);
    if (!by_name_.contains(name) && !by_name_.contains(default_table)) {
      throw files::ConfigError(fmt::format("{}: has neither a table [{}] for {} nor [{}]", file,
                                           files::quoted(name), trace, default_table));
    }
  }
}

const Bounds& Expectations::of(const std::string& trace) const {
  const auto found = by_name_.find(file_name(trace));
  return found == by_name_.end() ? by_name_.at(default_table) : found->second;
}

}  // namespace smaservo::replay
