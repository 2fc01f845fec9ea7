#pragma once
// Which live values are read in one round, where they are polled.

#include <vector>

#include "host-sim/page/servos/history.hpp"

namespace smaservo::page {

struct LiveRound {
  std::vector<std::size_t> fast, slow;  ///< signals of each round; one of these in each
};

/// All signals where the bus has room for them at the promised rate, else the first ones in the
/// order of what a page shows first, and one of the others in turn. Where others come by SYNC, all
/// that is polled comes in turn. `requests_per_s` is what the servo has for live values.
LiveRound live_round(double requests_per_s, const SignalSet* by_sync);

}  // namespace smaservo::page
