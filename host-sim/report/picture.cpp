#include "host-sim/report/picture.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <stdexcept>

#include "host-sim/report/gnuplot.hpp"
#include "host-sim/report/thin.hpp"

namespace smaservo::report {
namespace {

/// Greatest number of rows of a series in a picture, which is a thousand points wide.
constexpr std::size_t max_drawn_rows = 2000;

using Drawn = std::vector<const std::vector<double>*>;

Drawn drawn_columns(const Series& series) {
  Drawn all{series.x.get()};
  if (series.low != nullptr) {
    all.push_back(series.low.get());
  }
  all.push_back(series.y.get());
  for (const std::vector<double>* one : all) {
    if (one->size() != all.front()->size()) {
      throw std::logic_error("columns of different lengths: " + series.name);
    }
  }
  return all;
}

/// The series as gnuplot's data block. An undefined row ends a filled area only if it is blank.
std::string data_block(std::size_t number, const Series& series) {
  const Drawn columns = drawn_columns(series);
  const bool filled = series.low != nullptr;
  std::string text = fmt::format("$s{} << EOD\n", number);
  std::vector<double> values(columns.size());
  for (const std::size_t row : rows_to_show(columns, max_drawn_rows)) {
    std::ranges::transform(columns, values.begin(), [&](const auto* one) { return (*one)[row]; });
    const bool gap = std::ranges::any_of(values, [](double v) { return !std::isfinite(v); });
    text += filled && gap ? "\n" : plotted_row(values);
  }
  return text + "EOD\n";
}

/// The bars of a row, which are always long enough to be visible.
std::string spans_block(std::size_t number, const Series& series, int row, double shortest) {
  std::string text = fmt::format("$s{} << EOD\n", number);
  for (std::size_t i = 0; i < series.x->size(); ++i) {
    const double from = (*series.x)[i];
    text += plotted_row(std::array{from, static_cast<double>(-row),
                                   std::max((*series.y)[i] - from, shortest), 0.0});
  }
  return text + "EOD\n";
}

std::string look(const Series& series) {
  const std::string colour = fmt::format("lc rgb '{}'", on_white(series.colour));
  const char* dashes = series.dashed ? " dt 2" : "";
  switch (series.kind) {
    case Kind::line:
      return fmt::format("using 1:2 with lines {} lw {}{}", colour, series.width, dashes);
    case Kind::steps:
      return fmt::format("using 1:2 with steps {} lw {}{}", colour, series.width, dashes);
    case Kind::points:
      return fmt::format("using 1:2 with points pt 7 ps {} {}", 0.6 * series.width, colour);
    case Kind::band:
    case Kind::area:
      return fmt::format("using 1:2:3 with filledcurves {}", colour);
    case Kind::spans:
      return fmt::format("using 1:2:3:4 with vectors nohead lw 7 {}", colour);
  }
  return "";
}

std::string in_legend(std::string_view name) {
  return name.empty() ? "notitle" : "title " + plotted_text(name);
}

bool has_spans(const Panel& panel) {
  return std::ranges::find(panel.series, Kind::spans, &Series::kind) != panel.series.end();
}

std::string ticks_of(const char* axis, const Axis& a) {
  std::string text;
  for (const auto& [at, name] : a.ticks) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", in_quotes(name), at);
  }
  return text.empty() ? "" : fmt::format("set {}tics ({}) noenhanced\n", axis, text);
}

std::string range_of(const char* axis, const Axis& a) {
  const auto end = [](double value) { return std::isfinite(value) ? plotted(value) : "*"; };
  return fmt::format("set {}range [{}:{}]\n{}{}", axis, end(a.min), end(a.max),
                     a.log ? fmt::format("set logscale {}\nset format {} '%g'\n", axis, axis) : "",
                     ticks_of(axis, a));
}

/// Axes, lines across the panel and texts.
std::string settings(const Panel& panel, bool names_at_the_left) {
  std::string text = range_of("x", panel.x) + range_of("y", panel.y);
  if (!panel.half_width) {
    text += fmt::format("set lmargin at screen {}\nset rmargin at screen {}\n",
                        names_at_the_left ? 0.15 : 0.085, 0.925);
    text += panel.link.empty() ? "" : "set autoscale xfix\n";
  }
  const auto on_the_right = [](const Series& series) { return series.right; };
  if (std::ranges::any_of(panel.series, on_the_right)) {
    text += range_of("y2", panel.right) + "set y2tics\nset border 11 lc rgb '#666666'\n" +
            fmt::format("set y2label {}\n", plotted_text(panel.right.label));
    text += std::ranges::all_of(panel.series, on_the_right) ? "unset ytics\n" : "";
  }
  text += panel.equal ? "set size ratio -1\n" : "";
  for (const Rule& rule : panel.rules) {
    if (rule.vertical) {
      text += fmt::format("set arrow from {0}, graph 0 to {0}, graph 1 nohead dt 2 lc rgb '{1}'\n",
                          plotted(rule.at), on_white(rule.colour));
    }
  }
  for (const Note& note : panel.notes) {
    text += fmt::format("set label {} at {},{} front\n", plotted_text(note.text), plotted(note.x),
                        plotted(note.y));
  }
  return text;
}

double width_of(const Column& from, const Column& to) {
  const auto low = std::ranges::min_element(*from);
  const auto high = std::ranges::max_element(*to);
  return low == from->end() || high == to->end() ? 0 : *high - *low;
}

/// The rows of spans, from the top down, with their names as ticks.
struct SpanRows {
  Axis axis;
  std::string blocks;
  double longest = 0;
};
SpanRows span_rows(const Panel& panel) {
  SpanRows rows;
  for (const Series& series : panel.series) {
    rows.longest = std::max(rows.longest, width_of(series.x, series.y));
  }
  if (std::isfinite(panel.x.max - panel.x.min)) {
    rows.longest = panel.x.max - panel.x.min;
  }
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const auto row = static_cast<int>(i);
    rows.axis.ticks.emplace_back(-row, panel.series[i].name);
    rows.blocks += spans_block(i, panel.series[i], row, rows.longest / 1000);
  }
  rows.axis.min = 0.5 - static_cast<double>(panel.series.size());
  rows.axis.max = 0.5;
  return rows;
}

std::string drawn(Panel panel, bool names_at_the_left) {
  std::string data;
  std::vector<std::string> curves;
  const bool spans = has_spans(panel);
  if (spans) {
    SpanRows rows = span_rows(panel);
    data = std::move(rows.blocks);
    panel.y = std::move(rows.axis);
  }
  bool legend = false;
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const Series& series = panel.series[i];
    if (!shows(series.x) || !shows(series.y)) {
      continue;
    }
    data += spans ? "" : data_block(i, series);
    // Several series of one name get a single entry.
    const auto first = std::ranges::find(panel.series, series.name, &Series::name);
    const bool named = !spans && !series.name.empty() && &*first == &series;
    legend = legend || named;
    curves.push_back(fmt::format("$s{} {}{} {}", i, look(series), series.right ? " axes x1y2" : "",
                                 named ? in_legend(series.name) : "notitle"));
  }
  if (curves.empty()) {
    panel.x.min = panel.y.min = 0;
    panel.x.max = panel.y.max = 1;
    curves.emplace_back("NaN notitle");
  }
  for (const Rule& rule : panel.rules) {
    if (!rule.vertical) {
      legend = legend || !rule.name.empty();
      curves.push_back(fmt::format("{} with lines dt 2 lc rgb '{}' {}", plotted(rule.at),
                                   on_white(rule.colour), in_legend(rule.name)));
    }
  }
  const std::string more = settings(panel, names_at_the_left) + (legend ? "" : "unset key\n");
  return draw({panel.half_width ? 500 : 1000, panel.height, panel.x.label, panel.y.label}, data,
              more, curves);
}

}  // namespace

std::vector<std::string> pictures(std::span<const Panel> panels) {
  const bool names_at_the_left = std::ranges::any_of(panels, has_spans);
  std::vector<std::string> all;
  all.reserve(panels.size());
  for (const Panel& panel : panels) {
    all.push_back(panel.svg.empty() ? drawn(panel, names_at_the_left) : panel.svg);
  }
  return all;
}

}  // namespace smaservo::report
