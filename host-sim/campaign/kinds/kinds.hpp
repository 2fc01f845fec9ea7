#pragma once
// The kinds of campaigns.

#include <span>

#include "host-sim/campaign/plan.hpp"

namespace smaservo::campaign {

std::span<const Kind> all_kinds();

/// Random scenarios of the closed loop (host-sim/evaluate/closed_loop).
std::unique_ptr<const Trials> read_scenarios(KindTable& table);

}  // namespace smaservo::campaign
