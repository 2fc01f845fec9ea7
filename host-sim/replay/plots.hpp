#pragma once
// The pictures of a replay's report, drawn by gnuplot.

#include <vector>

#include "host-sim/replay/replay.hpp"
#include "host-sim/report/gnuplot.hpp"

namespace smaservo::replay {

/// Throws UserError when gnuplot is missing or fails.
std::vector<report::Plot> draw_plots(const ReplayResult& result);

}  // namespace smaservo::replay
