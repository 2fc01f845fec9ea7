#pragma once
// The pictures of a fit's report.

#include <vector>

#include "host-sim/identify/fit/fit.hpp"
#include "host-sim/report/gnuplot.hpp"

namespace smaservo::identify {

/// Of each run: measured and fitted strain and resistance, and what is left between them. Throws
/// UserError when gnuplot is missing or fails.
std::vector<report::Plot> draw_fit(const FitResult& fit, const std::vector<Run>& runs);

}  // namespace smaservo::identify
