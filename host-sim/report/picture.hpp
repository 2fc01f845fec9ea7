#pragma once
// The picture of a panel, which a report shows in print and without JavaScript.

#include <span>
#include <string>

#include "host-sim/report/panel.hpp"

namespace smaservo::report {

/// One SVG for each panel, drawn by gnuplot, or the panel's own `svg`. The y axes of all panels of
/// full width are aligned. Throws UserError if gnuplot is missing or fails.
std::vector<std::string> pictures(std::span<const Panel> panels);

}  // namespace smaservo::report
