#pragma once
// The data from which a browser draws the panels of a page (host-sim/page/front/src/report).

#include <span>
#include <string>

#include "host-sim/report/panel.hpp"

namespace smaservo::report {

/// One JSON object, {"columns": [[...]], "panels": [...]}, that may stand in an HTML script
/// element: it has no "<". A series names its columns by their places in `columns`; null is a gap,
/// and a panel that is a picture only. Columns that share rows hold 20 000 of them and 300 000
/// numbers at most, with every peak (thin.hpp); numbers have six digits, those along an x axis
/// nine.
std::string panels_json(std::span<const Panel> panels);

}  // namespace smaservo::report
