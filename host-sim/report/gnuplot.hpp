#pragma once
// Pictures by gnuplot.

#include <span>
#include <string>
#include <vector>

namespace smaservo::report {

struct Plot {
  std::string title;
  std::string caption;
  bool half_width;  ///< two of these stand side by side
  std::string svg;  ///< a document that needs nothing else and runs no script
};

struct Axes {
  int width, height;
  std::string x_label, y_label;
};

/// The SVG of a plot command over a data block, `more` being settings before it. Colours by name:
/// estimate, reference, band, measured. Throws UserError when gnuplot is missing or fails.
std::string draw(const Axes& axes, const std::string& data, const std::string& more,
                 const std::vector<std::string>& curves);

/// The same over two axes: by splot.
std::string draw_surface(const Axes& axes, const std::string& data, const std::string& more,
                         const std::vector<std::string>& surfaces);

/// As gnuplot reads it; what is not finite leaves a gap.
std::string plotted(double value);
/// These as a row of a data block.
std::string plotted_row(std::span<const double> values);

}  // namespace smaservo::report
