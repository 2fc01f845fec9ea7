#pragma once
// Modes, states, sets of faults and limit reasons as texts.

#include <optional>
#include <string>
#include <string_view>

#include "firmware/command.hpp"
#include "firmware/safety/faults/table.hpp"

namespace smaservo::text {

std::string_view mode_name(Mode mode);
std::optional<Mode> mode_of(std::string_view name);
std::string_view state_name(DeviceState state);
std::string_view health_name(Health health);
std::string_view limit_reason_name(LimitReason reason);

/// The names of all faults in the set, with a plus in between.
std::string names_of(FaultSet set);
/// Reads a set from a text like that of names_of(); nullopt if it contains an unknown name.
std::optional<FaultSet> named_faults(std::string_view names);
std::string limit_reason_names(std::uint32_t bits);

}  // namespace smaservo::text
