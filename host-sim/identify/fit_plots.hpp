#pragma once
// The panels of a fit's report.

#include <vector>

#include "host-sim/identify/fit/fit.hpp"
#include "host-sim/report/panel.hpp"

namespace smaservo::identify {

/// For each run: measured and fitted strain and resistance, and their differences.
std::vector<report::Panel> fit_panels(const FitResult& fit, const std::vector<Run>& runs);
/// The same of runs that were held out.
std::vector<report::Panel> held_out_panels(const std::vector<FittedRun>& fitted,
                                           const std::vector<Run>& runs, double nominal_stroke);

}  // namespace smaservo::identify
