#pragma once
// The pictures of a replay's report, drawn by gnuplot.

#include <string>
#include <vector>

#include "host-sim/replay.hpp"

namespace smaservo {

struct Plot {
  std::string title;
  std::string caption;
  bool half_width;  ///< two of these stand side by side
  std::string svg;  ///< a document that needs nothing else; the mouse shows coordinates
};

/// Throws UserError when gnuplot is missing or fails.
std::vector<Plot> draw_plots(const ReplayResult& result);

}  // namespace smaservo
