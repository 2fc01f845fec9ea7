#include "host-sim/simulate/closed_loop_report.hpp"

#include <fmt/format.h>
#include <utility>

#include "firmware/text/device_names.hpp"
#include "host-sim/report/html.hpp"
#include "model/units.hpp"

namespace smaservo::simulate {
namespace {

using report::Column;
using report::Panel;
using report::Series;

constexpr const char* in_time = "time";

/// One line of the picture of states and faults: a name and the spans of time in which it applied.
struct Row {
  std::string name;
  const char* colour;
  const Spans* spans;
};

std::vector<Row> time_table(const LoopRecord& record) {
  std::vector<Row> rows;
  const auto add = [&](const auto& all, auto name, const char* colour) {
    for (const auto& [key, spans] : all) {
      rows.push_back({std::string(name(key)), colour, &spans});
    }
  };
  add(record.states, text::state_name, "measured");
  add(record.limits, text::limit_reason_name, "estimate");
  add(record.warnings, fault_name, "warning");
  add(record.latched, fault_name, "fault");
  return rows;
}

/// Makes report columns from members of all points.
class LoopColumns {
 public:
  explicit LoopColumns(std::vector<LoopPoint> points) : points_(std::move(points)) {}

  Column operator()(double LoopPoint::* value) const {
    return report::column_of(points_, [value](const LoopPoint& p) { return p.*value; });
  }

 private:
  std::vector<LoopPoint> points_;
};

class LoopPlots {
 public:
  LoopPlots(const bench::ClosedLoopScenario& scenario, const LoopRecord& record)
      : scenario_(scenario),
        record_(record),
        of_(record.series.points()),
        time_(of_(&LoopPoint::time_s)),
        strain_(of_(&LoopPoint::strain_percent)),
        estimate_(of_(&LoopPoint::estimate_percent)) {}

  std::vector<Panel> all() const {
    std::vector<Panel> panels{strain(), error()};
    if (report::shows(of_(&LoopPoint::other_measured))) {
      panels.push_back(other());
    }
    for (Panel panel :
         {drive(), temperature(), stress(), times(),
          loop("Strain over resistance", "As the device measures the resistance.",
               "resistance in Ω", &LoopPoint::resistance_ohm),
          loop("Strain over temperature", "Over the temperature that the device estimates.",
               "temperature in °C", &LoopPoint::wire_degC)}) {
      panels.push_back(std::move(panel));
    }
    return panels;
  }

 private:
  Panel strain() const {
    Panel panel =
        wide("Strain", "Set-point, true strain and the observer's estimate.", "strain in %", 340);
    add(panel, &LoopPoint::setpoint_percent,
        {.name = "set-point", .colour = "measured", .kind = report::Kind::steps, .width = 2});
    add(panel, &LoopPoint::reference_percent,
        {.name = "reference of the planner", .colour = "planned", .dashed = true});
    panel.series.push_back(
        {.name = "true strain", .colour = "reference", .x = time_, .y = strain_, .width = 2});
    panel.series.push_back({.name = "estimate", .colour = "estimate", .x = time_, .y = estimate_});
    return panel;
  }

  Panel error() const {
    Panel panel =
        wide("Errors", "Of the estimate, and of the wire against the planner's reference.",
             "error in % of the stroke", 220);
    add(panel, &LoopPoint::control_error_percent,
        {.name = "true strain less reference", .colour = "reference"});
    add(panel, &LoopPoint::estimate_error_percent,
        {.name = "estimate less true strain", .colour = "estimate"});
    panel.rules.push_back({.at = 0, .name = "", .colour = "measured"});
    return panel;
  }

  Panel other() const {
    Panel panel = wide("Other modes",
                       "Modes that do not control the length, in SI units of the mode.", "", 240);
    add(panel, &LoopPoint::other_setpoint, {.name = "set-point", .colour = "measured", .width = 2});
    add(panel, &LoopPoint::other_measured,
        {.name = "as the device measures it", .colour = "estimate"});
    return panel;
  }

  Panel drive() const {
    Panel panel = wide("Current and power",
                       "The current that flows, and the power that the controller asks for.",
                       "current in A", 240);
    panel.y.min = 0;
    panel.right = {.label = "power in W", .min = 0};
    add(panel, &LoopPoint::power_W, {.name = "power", .colour = "band", .right = true, .width = 2});
    add(panel, &LoopPoint::current_A, {.name = "current", .colour = "estimate"});
    return panel;
  }

  Panel temperature() const {
    Panel panel = wide("Temperature", "The hottest point must stay below the limit.",
                       "temperature in °C", 280);
    add(panel, &LoopPoint::hottest_degC,
        {.name = "hottest point, true", .colour = "reference", .width = 2});
    add(panel, &LoopPoint::hot_spot_degC,
        {.name = "hottest point, as the device assumes", .colour = "measured"});
    add(panel, &LoopPoint::wire_degC, {.name = "wire, estimated", .colour = "estimate"});
    panel.rules.push_back(
        {scenario_.settings.limits.temperature_K - zero_degC_K, "limit", "fault"});
    return panel;
  }

  Panel stress() const {
    Panel panel = wide("Stress", "The true stress of the wire.", "stress in MPa", 200);
    panel.y.min = 0;
    add(panel, &LoopPoint::stress_MPa, {.name = "true stress", .colour = "reference"});
    return panel;
  }

  /// States, limit reasons, warnings and faults as bars.
  Panel times() const {
    Panel panel = wide(
        "States, limits, faults",
        "Grey: state. Blue: what limits the output. Amber: warnings. Red: latched faults.", "", 0);
    for (const Row& row : time_table(record_)) {
      panel.series.push_back(
          {.name = row.name,
           .colour = row.colour,
           .kind = report::Kind::spans,
           .x = report::column_of(*row.spans, [](const auto& span) { return span.first; }),
           .y = report::column_of(*row.spans, [](const auto& span) { return span.second; })});
    }
    panel.height = 90 + 18 * static_cast<int>(panel.series.size());
    return panel;
  }

  Panel loop(const char* title, const char* caption, const char* x_label,
             double LoopPoint::* over) const {
    const Column x = of_(over);
    return {.title = title,
            .caption = caption,
            .half_width = true,
            .height = 400,
            .x = {.label = x_label},
            .y = {.label = "strain in %"},
            .follows = in_time,
            .series = {
                {.name = "true strain",
                 .colour = "reference",
                 .x = x,
                 .y = strain_,
                 .at = time_,
                 .width = 2},
                {.name = "estimate", .colour = "estimate", .x = x, .y = estimate_, .at = time_}}};
  }

  /// Adds a series, unless it has nothing to show.
  void add(Panel& panel, double LoopPoint::* value, Series series) const {
    series.x = time_;
    series.y = of_(value);
    if (report::shows(series.y)) {
      panel.series.push_back(std::move(series));
    }
  }

  Panel wide(const char* title, const char* caption, const char* y_label, int height) const {
    return {.title = title,
            .caption = caption,
            .height = height,
            .x = {.label = "time in s", .min = 0, .max = scenario_.duration_s},
            .y = {.label = y_label},
            .link = in_time};
  }

  const bench::ClosedLoopScenario& scenario_;
  const LoopRecord& record_;
  LoopColumns of_;
  Column time_, strain_, estimate_;
};

std::string numbers_html(const bench::ClosedLoopScenario& scenario, const LoopRunResult& result) {
  files::TextTable table({{""}, {""}});
  table.add(
      {"hottest point, true",
       fmt::format("{:.1f} °C at {:.3f} s; limit {:.1f} °C", result.max_hottest_K - zero_degC_K,
                   result.max_hottest_s, scenario.settings.limits.temperature_K - zero_degC_K)});
  table.add({"greatest current", fmt::format("{:.0f} mA", 1e3 * result.max_current_A)});
  table.add({"greatest error of the estimate",
             fmt::format("{:.2f} % of the nominal stroke",
                         100 * result.max_estimate_error / scenario.settings.wire.nominal_stroke)});
  for (const auto& [fault, time_s] : result.faults) {
    table.add({fault_name(fault), fmt::format("latched at {:.3f} s", time_s)});
  }
  return table.html();
}

std::string steps_html(const bench::ClosedLoopScenario& scenario, const LoopRunResult& result) {
  if (result.strain_steps.empty()) {
    return "";
  }
  std::string remarks;
  for (const std::string& remark : unreached(scenario, result)) {
    remarks += fmt::format("<li>{}</li>\n", remark);
  }
  if (!remarks.empty()) {
    remarks = "<p>Outside of ±2 % of the stroke at the end:</p>\n<ul>\n" + remarks + "</ul>\n";
  }
  return "<h2>Steps</h2>\n" + report::steps_table(result.strain_steps).html() + remarks +
         "<p class=\"caption\">From and to are strain; overshoot and steady error (mean over the "
         "last quarter) are in % of the nominal stroke; settling is to ±2 % of it.</p>\n";
}

}  // namespace

void write_report(const std::string& path, const bench::ClosedLoopScenario& scenario,
                  const LoopRunResult& result, Units units) {
  std::string html = fmt::format("<p>{}</p>\n<p>{} steps, {:.4g} s, plant {}, wire {}</p>\n",
                                 files::escaped(scenario.note), result.steps, result.duration_s,
                                 bench::plant_name(scenario.plant.family),
                                 files::escaped(scenario.plant.wire.name));
  html += numbers_html(scenario, result);
  if (result.record) {
    html += report::plots_html(LoopPlots(scenario, *result.record).all(), units);
  }
  html += steps_html(scenario, result);
  html += report::listing_html("The true wire", files::to_toml(scenario.plant.wire));
  report::write_html(path, scenario.name, html);
}

}  // namespace smaservo::simulate
