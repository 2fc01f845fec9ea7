#pragma once
// The pictures of a replay's report, drawn by gnuplot.

#include <vector>

#include "host-sim/gnuplot.hpp"
#include "host-sim/replay.hpp"

namespace smaservo {

/// Throws UserError when gnuplot is missing or fails.
std::vector<Plot> draw_plots(const ReplayResult& result);

}  // namespace smaservo
