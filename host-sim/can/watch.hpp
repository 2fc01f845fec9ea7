#pragma once

#include <functional>

#include "host-sim/can/remote.hpp"

namespace smaservo::can {

struct WatchPlan {
  std::vector<std::string> names;  ///< of objects; empty: what tells most
  double period_s = 0.2;
  std::uint64_t count = 0;  ///< rows; 0: for ever
  std::string plot;         ///< one of the names, drawn below the table
};

/// Reads and shows, until it has been so often: as lines of values under a header or, on a
/// terminal, as a table in place. Throws UserError.
void watch(Remote& remote, const WatchPlan& plan, bool in_place,
           const std::function<void(const std::string&)>& show);

}  // namespace smaservo::can
