#pragma once
// What a report shows, stated once: static pictures (picture.hpp) and the data of the interactive
// panels (panel_json.hpp) are both made of it.

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace smaservo::report {

/// Numbers that series and panels share: a page holds each column once. NaN leaves a gap.
using Column = std::shared_ptr<const std::vector<double>>;

Column column(std::vector<double> values);

/// value(point) for all of them.
template <class Points, class Value>
Column column_of(const Points& points, Value value) {
  std::vector<double> values;
  values.reserve(points.size());
  for (const auto& point : points) {
    values.push_back(value(point));
  }
  return column(std::move(values));
}

/// Whether the column has anything to show.
bool shows(const Column& values);

inline constexpr double as_the_data = std::numeric_limits<double>::quiet_NaN();

// NOLINTBEGIN(readability-redundant-member-init): for designated initializers

struct Axis {
  std::string label = {};
  double min = as_the_data, max = as_the_data;
  bool log = false;
  std::vector<std::pair<double, std::string>> ticks = {};  ///< none: numbers
};

enum class Kind : unsigned char {
  line,
  steps,   ///< holds each value until the next x
  points,  ///< a dot for each row
  band,    ///< pale, from `low` to `y`, behind the lines
  area,   ///< full colour, from `low` to `y`: of several that are stacked, its own value is y - low
  spans,  ///< bars from `x` to `y` along the x axis, in a row of its own that has the series' name
};

/// Columns of a series have one length.
struct Series {
  /// In the legend. Series of one name are switched together; empty: no entry.
  std::string name = {};
  std::string colour = {};  ///< a role in colours(), or "#rrggbb"
  Kind kind = Kind::line;
  Column x = nullptr, y = nullptr;
  Column low = nullptr;  ///< of band and area
  /// Where the rows stand on the x axis of the panels that `follows` names: a loop shows the part
  /// to which those panels are zoomed, and the point under their cursor.
  Column at = nullptr;
  bool right = false;  ///< on the right y axis
  double width = 1;
  bool dashed = false;
};

/// A line across the whole panel.
struct Rule {
  double at;
  std::string name;  ///< in the legend; empty: no entry
  std::string colour;
  bool vertical = false;
};

/// A text in the panel, which begins at this point.
struct Note {
  double x, y;
  std::string text;
};

struct Panel {
  std::string title = {};
  std::string caption = {};
  bool half_width = false;  ///< two of these stand side by side
  int height = 280;         ///< of the 1000 or 500 that the panel is wide
  Axis x = {}, y = {}, right = {};
  std::string link = {};     ///< panels of one name share zoom and cursor along their x axes
  std::string follows = {};  ///< a name of linked panels, for series that have `at`
  bool equal = false;        ///< one unit is as long on both axes: a circle is round
  std::vector<Series> series = {};
  std::vector<Rule> rules = {};
  std::vector<Note> notes = {};
  /// What no series can say (a surface, a colour for each point), drawn by gnuplot.hpp: such a
  /// panel stays a picture.
  std::string svg = {};
};

// NOLINTEND(readability-redundant-member-init)

/// A colour with a meaning, on white and on a dark screen. They stay apart for colour-blind readers
/// and in grey print.
struct Role {
  std::string_view name, light, dark;
};
const std::vector<Role>& colours();

/// "#rrggbb" on white. Throws std::logic_error for a name that is no role.
std::string_view on_white(std::string_view colour);

}  // namespace smaservo::report
