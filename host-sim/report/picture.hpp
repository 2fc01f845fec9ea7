#pragma once
// The picture of a panel: what a report shows in print and without JavaScript.

#include <span>
#include <string>

#include "host-sim/report/panel.hpp"

namespace smaservo::report {

/// One SVG for each panel, drawn by gnuplot; `svg` of those that bring their own. The y axes of all
/// that have the full width stand above each other. Throws UserError when gnuplot is missing or
/// fails.
std::vector<std::string> pictures(std::span<const Panel> panels);

}  // namespace smaservo::report
