#pragma once
// The panels of a fit's report.

#include <vector>

#include "host-sim/identify/fit/fit.hpp"
#include "host-sim/report/panel.hpp"

namespace smaservo::identify {

/// For each run: measured and fitted strain and resistance, and their differences.
std::vector<report::Panel> fit_panels(const FitResult& fit, const std::vector<Run>& runs);

}  // namespace smaservo::identify
