#pragma once
// The kinds of campaigns.

#include <span>

#include "host-sim/campaign/plan.hpp"

namespace smaservo::campaign {

std::span<const Kind> all_kinds();

/// Random scenarios of the closed loop (host-sim/evaluate/closed_loop).
std::unique_ptr<const Trials> read_scenarios(KindTable& table);

/// A closed loop on wires drawn from the tolerance of their type, with a device that does not
/// change.
std::unique_ptr<const Trials> read_gains(KindTable& table);

}  // namespace smaservo::campaign
