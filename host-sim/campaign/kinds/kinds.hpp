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

/// Units that are calibrated and on which observers are judged, as by `evaluate`.
std::unique_ptr<const Trials> read_evaluate(KindTable& table);

/// Measured runs of many wires, to each of which the parameters are fitted, as by `identify`.
std::unique_ptr<const Trials> read_lot(KindTable& table);

}  // namespace smaservo::campaign
