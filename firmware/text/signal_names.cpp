#include "firmware/text/signal_names.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <vector>

#include "firmware/signals.hpp"
#include "model/files/error.hpp"
#include "model/files/similar.hpp"
#include "model/files/toml/fields.hpp"

namespace smaservo::text {
namespace {

struct Renamed {
  std::string_view former, now;
};

constexpr std::array on_the_bus{
    Renamed{"temperature_K", "wire_temperature_K"}, Renamed{"ambient_K", "estimated_ambient_K"},
    Renamed{"measured_A", "current_A"}, Renamed{"measured_V", "voltage_V"}};

constexpr std::array in_logs{Renamed{"wire_K", "wire_temperature_K"},
                             Renamed{"believed_ambient_K", "estimated_ambient_K"},
                             Renamed{"power_W", "wanted_power_W"}};

constexpr std::array<std::string_view, 4> shares{"strain", "strain_sd", "martensite", "r_phase"};

constexpr std::array<Kind, 9> dimensions{kind::velocity, kind::temperature, kind::length,
                                         kind::stress,   kind::power,       kind::current,
                                         kind::voltage,  kind::resistance,  kind::force};

/// Whether a name has the suffix of SI's unit of this kind.
constexpr bool is_of(std::string_view name, Kind kind) {
  const std::string_view suffix = kind.front().suffix;
  return name.size() > suffix.size() && name.ends_with(suffix) &&
         name[name.size() - suffix.size() - 1] == '_';
}

constexpr Kind kind_of(std::string_view name) {
  for (const Kind kind : dimensions) {
    if (is_of(name, kind)) {
      return kind;
    }
  }
  return std::ranges::find(shares, name) != shares.end() ? Kind(kind::number) : Kind(kind::count);
}

/// Whether `name` is this signal's without its unit, or with another one of its kind.
bool is_in_another_unit(std::string_view name, std::string_view signal, Kind kind) {
  const std::string_view suffix = kind.front().suffix;
  signal.remove_suffix(suffix.empty() ? 0 : suffix.size() + 1);
  return name == signal || std::ranges::any_of(kind, [&](const Unit& unit) {
           return name == files::key_with(signal, unit.suffix);
         });
}

}  // namespace

Kind signal_kind(std::size_t row) {
  return kind_of(signal_rows<double>.at(row).name);
}

std::size_t signal_row(const std::string& name) {
  const std::string_view bare =
      std::string_view(name).substr(name.starts_with(live_prefix) ? live_prefix.size() : 0);
  const auto& rows = signal_rows<double>;
  const auto* const found = std::ranges::find(rows, bare, &Signal<double>::name);
  if (found != rows.end()) {
    return static_cast<std::size_t>(found - rows.begin());
  }
  if (const std::string_view now = renamed_signal(bare); !now.empty()) {
    throw files::UserError(fmt::format("{}: is now called {}", name, now));
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (is_in_another_unit(bare, rows[i].name, signal_kind(i))) {
      throw files::UserError(fmt::format("{}: signals are in SI: {}", name, rows[i].name));
    }
  }
  std::vector<std::string> names;
  names.reserve(signal_count);
  for (const Signal<double>& row : rows) {
    names.emplace_back(row.name);
  }
  throw files::UserError(fmt::format("{}: no such signal{}; there are: {}", name,
                                     files::did_you_mean(bare, names), fmt::join(names, ", ")));
}

std::string_view renamed_signal(std::string_view former) {
  const auto* const found = std::ranges::find(on_the_bus, former, &Renamed::former);
  return found == on_the_bus.end() ? std::string_view() : found->now;
}

std::string_view former_column(std::string_view now) {
  const auto* const found = std::ranges::find(in_logs, now, &Renamed::now);
  return found == in_logs.end() ? std::string_view() : found->former;
}

}  // namespace smaservo::text
