#pragma once
// The content of a report, described once: static pictures (picture.hpp) and the data of the
// interactive panels (panel_json.hpp) are both made from it.

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host-sim/units.hpp"

namespace smaservo::report {

/// Numbers that series and panels share, so that a page contains each column once. NaN leaves a
/// gap.
using Column = std::shared_ptr<const std::vector<double>>;

Column column(std::vector<double> values);

/// The column of value(point) for all points.
template <class Points, class Value>
Column column_of(const Points& points, Value value) {
  std::vector<double> values;
  values.reserve(points.size());
  for (const auto& point : points) {
    values.push_back(value(point));
  }
  return column(std::move(values));
}

/// Whether the column has a finite value.
bool shows(const Column& values);

inline constexpr double as_the_data = std::numeric_limits<double>::quiet_NaN();

// NOLINTBEGIN(readability-redundant-member-init): for designated initializers

struct Axis {
  std::string label = {};
  double min = as_the_data, max = as_the_data;
  bool log = false;
  std::vector<std::pair<double, std::string>> ticks = {};  ///< empty: the axis has numbers
};

enum class Kind : unsigned char {
  line,
  steps,   ///< each value is held until the next x
  points,  ///< a dot for each row
  band,    ///< pale area from `low` to `y`, behind the lines
  /// Full-colour area from `low` to `y`; if several are stacked, the value of one is y - low.
  area,
  /// Bars from `x` to `y` along the x axis, in a separate row with the name of the series.
  spans,
};

/// All columns of a series have the same length.
struct Series {
  /// Name in the legend. Series of one name are shown and hidden together; empty: no entry.
  std::string name = {};
  std::string colour = {};  ///< a role in colours(), or "#rrggbb"
  Kind kind = Kind::line;
  Column x = nullptr, y = nullptr;
  Column low = nullptr;  ///< lower edge of a band or area
  /// The rows' positions on the x axis of the panels that `follows` names: a loop shows the part to
  /// which those panels are zoomed, and the point under their cursor.
  Column at = nullptr;
  bool right = false;  ///< uses the right y axis
  double width = 1;
  bool dashed = false;
};

/// A line across the whole panel.
struct Rule {
  double at;
  std::string name;  ///< name in the legend; empty: no entry
  std::string colour;
  bool vertical = false;
};

/// A text in the panel that begins at this point.
struct Note {
  double x, y;
  std::string text;
};

struct Panel {
  std::string title = {};
  std::string caption = {};
  bool half_width = false;  ///< two such panels stand side by side
  int height = 280;         ///< height in units of which the panel's width has 1000 or 500
  Axis x = {}, y = {}, right = {};
  std::string link = {};     ///< panels of the same name share zoom and cursor along their x axes
  std::string follows = {};  ///< name of linked panels, for series that have `at`
  bool equal = false;        ///< a unit has the same length on both axes: a circle is round
  std::vector<Series> series = {};
  std::vector<Rule> rules = {};
  std::vector<Note> notes = {};
  /// Content that no series can describe (a surface, a colour for each point), drawn by
  /// gnuplot.hpp: such a panel is always a picture.
  std::string svg = {};
};

// NOLINTEND(readability-redundant-member-init)

/// The panels in these units: a label that ends in " in UNIT" gives the unit of what is on its axis
/// (series, limits, ticks, rules, notes). Temperatures are in °C or K, stresses in MPa or Pa,
/// currents in mA or A, powers in mW or W, lengths in µm or m; a length in mm stays so on the
/// bench. All others, such as %, stay as they are, and so does a difference of temperatures: only
/// an axis that is called "temperature" has a zero that moves. Columns that are shared stay shared.
std::vector<Panel> in_units(std::vector<Panel> panels, Units units);

/// A colour with a meaning, on white and on a dark screen. The colours are distinguishable for
/// colour-blind readers and in grey print.
struct Role {
  std::string_view name, light, dark;
};
const std::vector<Role>& colours();

/// The colour as "#rrggbb" on white. Throws std::logic_error for a name that is not a role.
std::string_view on_white(std::string_view colour);

}  // namespace smaservo::report
