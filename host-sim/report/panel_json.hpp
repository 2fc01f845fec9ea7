#pragma once
// The data from which a browser draws the panels of a page (host-sim/page/front/src/report).

#include <span>
#include <string>

#include "host-sim/report/panel.hpp"

namespace smaservo::report {

/// One JSON object, {"columns": [[...]], "panels": [...]}, that may stand in an HTML script
/// element, since it contains no "<". A series refers to its columns by their index in `columns`;
/// null is a gap, or a panel that is only a picture. Columns that share rows hold at most 20 000
/// rows and 300 000 numbers, with every peak (thin.hpp); numbers have six digits, those along an x
/// axis nine.
std::string panels_json(std::span<const Panel> panels);

}  // namespace smaservo::report
