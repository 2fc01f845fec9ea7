#include "host-sim/device_names.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace smaservo {
namespace {

constexpr std::array<std::string_view, mode_count> modes{
    "off",    "current",  "power", "resistance",    "temperature",
    "strain", "position", "force", "identification"};
constexpr std::array<std::string_view, 6> states{"starting", "ready",    "arming",
                                                 "running",  "stopping", "fault"};
constexpr std::array<std::string_view, 3> healths{"good", "searching", "doubtful"};
constexpr std::array<std::string_view, static_cast<std::size_t>(LimitReason::count)> reasons{
    "least_current", "current", "power",  "temperature", "strain",
    "stress",        "duty",    "supply", "trajectory"};
constexpr std::array<std::string_view, static_cast<std::size_t>(Fault::count)> faults{
    "none",
    "supply_low",
    "supply_high",
    "over_current",
    "current_saturated",
    "voltage_saturated",
    "current_offset",
    "current_control",
    "current_while_off",
    "driver_fault",
    "driver_hot",
    "wire_open",
    "wire_short",
    "sense_lead_open",
    "no_response",
    "over_temperature",
    "overheat_signature",
    "heating_rate",
    "load_lost",
    "over_stress",
    "over_strain",
    "clamp_slip",
    "drift",
    "cycles",
    "cold_resistance",
    "duty",
    "model_divergence",
    "estimate_invalid",
    "following_error",
    "power_balance",
    "ambient_range",
    "started_outside",
    "sample_stale",
    "sample_frozen",
    "deadline_missed",
    "command_timeout",
    "emergency_stop",
    "cooling_timeout",
    "bus_lost",
    "duplicate_node",
    "unclean_boot",
    "store_corrupt",
    "bad_configuration",
    "not_configured",
};

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
  const auto found = std::ranges::find(modes, name);
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
  return reasons.at(static_cast<std::size_t>(reason));
}
std::string_view fault_name(Fault fault) {
  return faults.at(static_cast<std::size_t>(fault));
}

std::string names_of(FaultSet set) {
  std::string text;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    if (set.has(static_cast<Fault>(i))) {
      add(text, faults.at(i));
    }
  }
  return text;
}

std::string limit_reason_names(std::uint32_t bits) {
  std::string text;
  for (std::size_t i = 0; i < reasons.size(); ++i) {
    if ((bits >> i & 1U) != 0) {
      add(text, reasons.at(i));
    }
  }
  return text;
}

}  // namespace smaservo
