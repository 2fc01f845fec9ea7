#include "firmware/text/signal_names.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <vector>

#include "firmware/signals.hpp"
#include "model/files/error.hpp"
#include "model/files/similar.hpp"

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

}  // namespace

std::size_t signal_row(const std::string& name) {
  const auto& rows = signal_rows<double>;
  const auto* const found = std::ranges::find(rows, name, &Signal<double>::name);
  if (found != rows.end()) {
    return static_cast<std::size_t>(found - rows.begin());
  }
  if (const std::string_view now = renamed_signal(name); !now.empty()) {
    throw files::UserError(fmt::format("{}: is now called {}", name, now));
  }
  std::vector<std::string> names;
  names.reserve(signal_count);
  for (const Signal<double>& row : rows) {
    names.emplace_back(row.name);
  }
  throw files::UserError(fmt::format("{}: no such signal{}; there are: {}", name,
                                     files::did_you_mean(name, names), fmt::join(names, ", ")));
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
