#pragma once

#include <functional>

#include "host-sim/can/remote.hpp"
#include "host-sim/units.hpp"

namespace smaservo::can {

struct WatchPlan {
  std::vector<std::string> names;  ///< names of objects; empty: a default selection
  double period_s = 0.2;
  std::uint64_t count = 0;  ///< number of rows; 0: no end
  std::string plot;         ///< one of the names, whose values are drawn below the table
  Units units = Units::bench;
};

/// Reads and shows the objects `plan.count` times: as CSV lines after a header or, if `in_place`,
/// as one table after the other, for which the caller clears the terminal. A name without a unit is
/// shown with that of `plan.units`; live.setpoint and live.reference with that of the mode. The
/// columns of CSV keep the unit that they begin with: while the mode has another, their fields are
/// empty, which `remark` is told once. Throws UserError.
void watch(Remote& remote, const WatchPlan& plan, bool in_place,
           const std::function<void(const std::string&)>& show,
           const std::function<void(const std::string&)>& remark);

}  // namespace smaservo::can
