#include "firmware/text/device_names.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace smaservo::text {
namespace {

constexpr std::array<std::string_view, mode_count> modes{
    "off",    "current",  "power", "resistance",    "temperature",
    "strain", "position", "force", "identification"};
constexpr std::array<std::string_view, 6> states{"starting", "ready",    "arming",
                                                 "running",  "stopping", "fault"};
constexpr std::array<std::string_view, 3> healths{"good", "searching", "doubtful"};
constexpr std::array<std::string_view, static_cast<std::size_t>(LimitReason::count)> limit_names{
    "min_current", "current", "power",  "temperature", "strain",
    "stress",      "duty",    "supply", "trajectory",  "protection"};

void add(std::string& to, std::string_view name) {
  if (!to.empty()) {
    to += '+';
  }
  to += name;
}

}  // namespace

std::string_view mode_name(Mode mode) {
  return modes.at(static_cast<std::size_t>(mode));
}
std::optional<Mode> mode_of(std::string_view name) {
  const auto* const found = std::ranges::find(modes, name);
  return found == modes.end() ? std::nullopt
                              : std::optional(static_cast<Mode>(found - modes.begin()));
}
std::string_view state_name(DeviceState state) {
  return states.at(static_cast<std::size_t>(state));
}
std::string_view health_name(Health health) {
  return healths.at(static_cast<std::size_t>(health));
}
std::string_view limit_reason_name(LimitReason reason) {
  return limit_names.at(static_cast<std::size_t>(reason));
}

std::string names_of(FaultSet set) {
  std::string text;
  for (std::size_t i = 1; i < static_cast<std::size_t>(Fault::count); ++i) {
    const auto fault = static_cast<Fault>(i);
    if (set.has(fault)) {
      add(text, fault_name(fault));
    }
  }
  return text;
}

std::optional<FaultSet> named_faults(std::string_view names) {
  FaultSet set;
  while (!names.empty()) {
    const std::size_t plus = std::min(names.find('+'), names.size());
    const auto* const row = std::ranges::find(fault_rows, names.substr(0, plus), &FaultRow::name);
    if (row == fault_rows.end()) {
      return std::nullopt;
    }
    set.set(row->fault);
    names.remove_prefix(std::min(plus + 1, names.size()));
  }
  return set;
}

std::string limit_reason_names(std::uint32_t bits) {
  std::string text;
  for (std::size_t i = 0; i < limit_names.size(); ++i) {
    if ((bits >> i & 1U) != 0) {
      add(text, limit_names.at(i));
    }
  }
  return text;
}

}  // namespace smaservo::text
