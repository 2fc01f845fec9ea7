#pragma once

#include <functional>

#include "host-sim/can/remote.hpp"

namespace smaservo::can {

struct WatchPlan {
  std::vector<std::string> names;  ///< names of objects; empty: a default selection
  double period_s = 0.2;
  std::uint64_t count = 0;  ///< number of rows; 0: no end
  std::string plot;         ///< one of the names, whose values are drawn below the table
};

/// Reads and shows the objects `plan.count` times: as CSV lines after a header or, if `in_place`,
/// as one table after the other, for which the caller clears the terminal. Throws UserError.
void watch(Remote& remote, const WatchPlan& plan, bool in_place,
           const std::function<void(const std::string&)>& show);

}  // namespace smaservo::can
