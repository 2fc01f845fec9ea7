#pragma once
// The pictures of a fit's report.

#include <vector>

#include "host-sim/identify/fit/fit.hpp"
#include "host-sim/report/gnuplot.hpp"

namespace smaservo::identify {

/// Plots for each run: measured and fitted strain and resistance, and their differences. Throws
/// UserError when gnuplot is missing or fails.
std::vector<report::Plot> draw_fit(const FitResult& fit, const std::vector<Run>& runs);

}  // namespace smaservo::identify
