#pragma once
// The panels of a replay's report.

#include <vector>

#include "host-sim/replay/replay.hpp"
#include "host-sim/report/panel.hpp"

namespace smaservo::replay {

std::vector<report::Panel> panels_of(const ReplayResult& result);

}  // namespace smaservo::replay
