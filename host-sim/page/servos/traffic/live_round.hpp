#pragma once
// Which live values are read in one round, where they are polled.

#include <vector>

#include "host-sim/page/servos/history.hpp"

namespace smaservo::page {

struct LiveRound {
  std::vector<std::size_t> fast, slow;  ///< signals of each round; one of these in each
};

/// Which signals are polled in each round. Where the bus has room, these are all of them at the
/// promised rate. Where it has not, the signals that a page shows first are polled in every round,
/// and the others take turns, one a round. Where the servo sends signals by SYNC (`by_sync`), these
/// are not polled, and all others take turns. `requests_per_s` is the number of requests for
/// live values that the bus has room for, of this servo.
LiveRound live_round(double requests_per_s, const SignalSet* by_sync);

}  // namespace smaservo::page
