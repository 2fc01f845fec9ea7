#pragma once
// Pictures by gnuplot. Panels that panel.hpp can describe are drawn through picture.hpp.

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace smaservo::report {

struct Axes {
  int width, height;
  std::string x_label, y_label;
};

/// The SVG of curves over a data block; `more` are gnuplot's settings before the plot command.
/// Colours have the names of colours() in panel.hpp. Throws UserError if gnuplot is missing or
/// fails.
std::string draw(const Axes& axes, const std::string& data, const std::string& more,
                 const std::vector<std::string>& curves);

/// Like draw(), with surfaces over two axes (splot).
std::string draw_surface(const Axes& axes, const std::string& data, const std::string& more,
                         const std::vector<std::string>& surfaces);

/// The number as gnuplot reads it; a value that is not finite leaves a gap.
std::string plotted(double value);
/// A text from outside in gnuplot's quotes.
std::string in_quotes(std::string_view text);
/// A text from outside as a title or label, without gnuplot's markup.
std::string plotted_text(std::string_view text);
/// The numbers as a row of a data block.
std::string plotted_row(std::span<const double> values);

}  // namespace smaservo::report
