#pragma once

#include <functional>

#include "host-sim/can/remote.hpp"

namespace smaservo::can {

struct WatchPlan {
  std::vector<std::string> names;  ///< of objects; empty: a default selection
  double period_s = 0.2;
  std::uint64_t count = 0;  ///< rows; 0: for ever
  std::string plot;         ///< one of the names, drawn below the table
};

/// Reads and shows the objects `plan.count` times: as CSV lines under a header or, `in_place`, as a
/// table at a time, for which the caller empties the terminal. Throws UserError.
void watch(Remote& remote, const WatchPlan& plan, bool in_place,
           const std::function<void(const std::string&)>& show);

}  // namespace smaservo::can
