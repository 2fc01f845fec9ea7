#include "host-sim/simulate/closed_loop_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "firmware/text/device_names.hpp"
#include "host-sim/report/html.hpp"
#include "model/units.hpp"

namespace smaservo::simulate {
namespace {

constexpr const char* data_columns =
    "# time setpoint reference strain estimate I P wire hot_spot hottest stress other measured\n";

std::string data_block(const std::vector<LoopPoint>& points) {
  std::string text = fmt::format("$data << EOD\n{}", data_columns);
  for (const LoopPoint& p : points) {
    const std::array columns{
        p.time_s,     p.setpoint_percent, p.reference_percent, p.strain_percent, p.estimate_percent,
        p.current_A,  p.power_W,          p.wire_degC,         p.hot_spot_degC,  p.hottest_degC,
        p.stress_MPa, p.other_setpoint,   p.other_measured};
    text += report::plotted_row(columns);
  }
  return text + "EOD\n";
}

/// One line of the picture of states and faults: a name and the spans in which it held.
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
  add(record.warnings, fault_name, "0xddaa33");
  add(record.latched, fault_name, "0xb00020");
  return rows;
}

class LoopPlots {
 public:
  LoopPlots(const bench::ClosedLoopScenario& scenario, const LoopRecord& record)
      : scenario_(scenario),
        record_(record),
        points_(record.series.points()),
        data_(data_block(points_)) {}

  std::vector<report::Plot> all() const {
    std::vector<report::Plot> plots{strain()};
    if (shows(&LoopPoint::other_measured)) {
      plots.push_back(other());
    }
    for (report::Plot plot : {drive(), temperature(), stress(), times()}) {
      plots.push_back(std::move(plot));
    }
    return plots;
  }

 private:
  bool shows(double LoopPoint::* value) const {
    return std::ranges::any_of(points_,
                               [&](const LoopPoint& p) { return std::isfinite(p.*value); });
  }

  report::Plot strain() const {
    std::vector<std::string> curves;
    if (shows(&LoopPoint::setpoint_percent)) {
      curves.emplace_back("$data using 1:2 with steps lc rgb measured lw 2 title 'set-point'");
    }
    if (shows(&LoopPoint::reference_percent)) {
      curves.emplace_back(
          "$data using 1:3 with lines lc rgb '#228833' dt 2 title 'reference of the planner'");
    }
    curves.emplace_back("$data using 1:4 with lines lc rgb reference lw 2 title 'true strain'");
    curves.emplace_back("$data using 1:5 with lines lc rgb estimate title 'estimate'");
    return wide("Strain", "Set-point, true strain and the observer's estimate.", "strain in %", 340,
                "", curves);
  }

  report::Plot other() const {
    return wide("Other modes", "Modes that do not control the length, in SI units of the mode.", "",
                240, "",
                {"$data using 1:12 with lines lc rgb measured lw 2 title 'set-point'",
                 "$data using 1:13 with lines lc rgb estimate title 'as the device measures it'"});
  }

  report::Plot drive() const {
    return wide("Current and power",
                "The current that flows, and the power that the controller asks for.",
                "current in A", 240,
                "set y2label 'power in W'\nset y2tics\nset y2range [0:*]\nset yrange [0:*]\n"
                "set border 11\n",
                {"$data using 1:7 axes x1y2 with lines lc rgb band lw 2 title 'power'",
                 "$data using 1:6 with lines lc rgb estimate title 'current'"});
  }

  report::Plot temperature() const {
    std::vector<std::string> curves{
        "$data using 1:10 with lines lc rgb reference lw 2 title 'hottest point, true'"};
    if (shows(&LoopPoint::hot_spot_degC)) {
      curves.emplace_back(
          "$data using 1:9 with lines lc rgb measured title 'hottest point, as the device "
          "assumes'");
    }
    curves.emplace_back("$data using 1:8 with lines lc rgb estimate title 'wire, estimated'");
    curves.push_back(fmt::format("{} with lines lc rgb '#b00020' dt 2 title 'limit'",
                                 scenario_.settings.limits.temperature_K - zero_degC_K));
    return wide("Temperature", "The hottest point must stay below the limit.", "temperature in °C",
                280, "", curves);
  }

  report::Plot stress() const {
    return wide("Stress", "The true stress of the wire.", "stress in MPa", 200,
                "set yrange [0:*]\n", {"$data using 1:11 with lines lc rgb reference notitle"});
  }

  /// States, limit reasons, warnings and faults as bars.
  report::Plot times() const {
    const std::vector<Row> rows = time_table(record_);
    std::string more =
        fmt::format("set yrange [{}:0.5]\nset ytics (", 0.5 - static_cast<double>(rows.size()));
    std::string data;
    std::vector<std::string> curves;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto y = -static_cast<double>(i);
      more += fmt::format("{}'{}' {}", i == 0 ? "" : ", ", rows[i].name, y);
      data += fmt::format("$row{} << EOD\n", i);
      for (const auto& [from_s, to_s] : *rows[i].spans) {
        data += fmt::format("{:.6g} {} {:.6g} 0\n", from_s, y,
                            std::max(to_s - from_s, scenario_.duration_s / 1000));
      }
      data += "EOD\n";
      curves.push_back(fmt::format(
          "$row{} using 1:2:3:4 with vectors nohead lw 7 lc rgb {} notitle", i, rows[i].colour));
    }
    more += ") noenhanced\n" + fmt::format("set xrange [0:{}]\n", scenario_.duration_s);
    report::Plot plot{
        "States, limits, faults",
        "Grey: state. Blue: what limits the output. Amber: warnings. Red: latched faults.", false,
        report::draw({1000, 90 + 18 * static_cast<int>(rows.size()), "time in s", ""}, data,
                     margins + more, curves)};
    return plot;
  }

  static constexpr const char* margins = "set lmargin at screen 0.14\nset rmargin at screen 0.91\n";

  report::Plot wide(const char* title, const char* caption, const char* y_label, int height,
                    const std::string& more, const std::vector<std::string>& curves) const {
    return {title, caption, false,
            report::draw({1000, height, "time in s", y_label}, data_,
                         margins + fmt::format("set xrange [0:{}]\n", scenario_.duration_s) + more,
                         curves)};
  }

  const bench::ClosedLoopScenario& scenario_;
  const LoopRecord& record_;
  std::vector<LoopPoint> points_;
  std::string data_;
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

std::string steps_html(const LoopRunResult& result) {
  if (result.strain_steps.empty()) {
    return "";
  }
  return "<h2>Steps</h2>\n" + report::steps_table(result.strain_steps).html() +
         "<p class=\"caption\">From and to are strain; overshoot and steady error (mean over the "
         "last quarter) are in % of the nominal stroke; settling is to ±2 % of it.</p>\n";
}

}  // namespace

void write_report(const std::string& path, const bench::ClosedLoopScenario& scenario,
                  const LoopRunResult& result) {
  std::string html = fmt::format("<p>{}</p>\n<p>{} steps, {:.4g} s, plant {}, wire {}</p>\n",
                                 files::escaped(scenario.note), result.steps, result.duration_s,
                                 bench::plant_name(scenario.plant.family),
                                 files::escaped(scenario.plant.wire.name));
  html += numbers_html(scenario, result);
  if (result.record) {
    html += report::plots_html(LoopPlots(scenario, *result.record).all());
  }
  html += steps_html(result);
  html += report::listing_html("The true wire", files::to_toml(scenario.plant.wire));
  report::write_html(path, scenario.name, html);
}

}  // namespace smaservo::simulate
