#include "host-sim/papers/figures/003/paper_003.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "host-sim/papers/figures/figure.hpp"
#include "host-sim/report/gnuplot.hpp"
#include "model/units.hpp"

namespace smaservo::figures {
namespace {

using report::Column;
using report::Panel;
using report::Series;

// Figure 2

/// The corners (β, α) of a wire's staircase, after the temperature went down from 120 °C, up, and
/// down again.
constexpr double staircase_top = 120;
std::vector<std::pair<double, double>> staircase_corners() {
  auto path = papers::Staircase<double, 16>::cooled(staircase_top, staircase_top);
  for (const double to : {48.0, 100.0, 62.0, 90.0, 72.0}) {
    path.move(to, [](double, double, double, double) { return 0.0; });
  }
  std::vector<std::pair<double, double>> corners;
  path.each_settled(
      [&](double /*sign*/, double hot, double cold) { corners.emplace_back(cold, hot); });
  corners.emplace_back(path.input, path.newest());
  corners.emplace_back(path.input, path.input);
  return corners;
}

Series polyline(const char* name, const char* colour, std::vector<double> x,
                std::vector<double> y) {
  return {.name = name,
          .colour = colour,
          .x = report::column(std::move(x)),
          .y = report::column(std::move(y)),
          .width = 2};
}

Panel relay_panel() {
  return {
      .title = "one relay",
      .caption = "Austenite from α on, on heating; martensite again from β on, on cooling.",
      .half_width = true,
      .height = 400,
      .x = {.label = "temperature", .ticks = {{50, "β"}, {90, "α"}}},
      .y = {.label = "", .min = -0.2, .max = 1.3, .ticks = {{0, "martensite"}, {1, "austenite"}}},
      .series = {polyline("heating", "heating", {30, 90, 90, 110}, {0, 0, 1, 1}),
                 polyline("cooling", "cooling", {110, 50, 50, 30}, {1, 1, 0, 0})}};
}

/// The area between the staircase and the top is martensite.
Panel plane_panel() {
  std::vector<double> beta, alpha;
  for (const auto& [cold, hot] : staircase_corners()) {
    beta.push_back(cold);
    alpha.push_back(hot);
  }
  std::vector<double> martensite_beta = beta;
  std::vector<double> martensite_alpha = alpha;
  martensite_beta.push_back(staircase_top);
  martensite_alpha.push_back(staircase_top);
  const auto flat = [](std::size_t rows, double value) {
    return report::column(std::vector<double>(rows, value));
  };
  const Column all_x = report::column({30, 120});
  return {.title = "all relays",
          .caption =
              "After 120, 48, 100, 62, 90 and 72 °C: the staircase between the two is the "
              "memory.",
          .half_width = true,
          .height = 400,
          .x = {.label = "β in °C", .min = 30, .max = 120},
          .y = {.label = "α in °C", .min = 30, .max = 120},
          .equal = true,
          .series = {{.name = "",
                      .colour = "#f5d0c0",
                      .kind = report::Kind::area,
                      .x = all_x,
                      .y = flat(2, staircase_top),
                      .low = all_x},
                     {.name = "",
                      .colour = "band",
                      .kind = report::Kind::area,
                      .x = report::column(martensite_beta),
                      .y = flat(martensite_beta.size(), staircase_top),
                      .low = report::column(martensite_alpha)},
                     polyline("staircase", "estimate", beta, alpha),
                     {.name = "α = β", .colour = "measured", .x = all_x, .y = all_x}},
          .notes = {{68, 108, "martensite"}, {34, 70, "austenite"}}};
}

PaperFigure relay_figure() {
  return {2,
          "The relay, and the plane of all relays",
          "What the wire remembers are the corners of the staircase: the turning points that are "
          "still open.",
          {relay_panel(), plane_panel()}};
}

// Figure 3

PaperFigure loop_figure() {
  const LoopSetup setup = loop_003();
  const auto references = references_003(false);
  FixedController fixed = fixed_003(setup);
  AdaptiveController adaptive = adaptive_003(setup);
  FixedController best(loop_design(setup), 0.025);
  const auto initial = run_loop(setup, fixed, references);
  const auto final_ = run_loop(setup, adaptive, references);
  std::vector<double> time_s, reference, first, last, first_error, last_error;
  for (std::size_t i = 0; i < initial.size(); ++i) {
    time_s.push_back(initial[i].time_s);
    reference.push_back(initial[i].reference.temperature_K - zero_degC_K);
    first.push_back(initial[i].truth.temperature_K - zero_degC_K);
    last.push_back(final_[i].truth.temperature_K - zero_degC_K);
    first_error.push_back(first.back() - reference.back());
    last_error.push_back(last.back() - reference.back());
  }
  const Column time = report::column(std::move(time_s));
  const auto line = [&](const char* name, const char* colour, std::vector<double> y,
                        double width = 1) {
    return Series{.name = name,
                  .colour = colour,
                  .x = time,
                  .y = report::column(std::move(y)),
                  .width = width};
  };
  const auto error = [](const std::vector<LoopRow>& rows) { return tracking_error_K(rows, 2); };
  Panel tracking{.title = "temperature",
                 .caption = "Reference and both runs, whose lines cover each other.",
                 .height = 320,
                 .x = {.label = "time in s"},
                 .y = {.label = "temperature in °C"},
                 .link = "time",
                 .series = {line("reference", "measured", std::move(reference), 4),
                            line("initial", "reference", std::move(first)),
                            line("final", "estimate", std::move(last))}};
  Panel errors{
      .title = "tracking error",
      .caption = fmt::format(
          "Root mean square: initial {:.2f} K, final {:.2f} K; the fixed controller with the "
          "best gain for this very run {:.2f} K.",
          error(initial), error(final_), error(run_loop(setup, best, references))),
      .height = 320,
      .x = {.label = "time in s"},
      .y = {.label = "true less reference in K", .min = -2.5, .max = 2.5},
      .link = "time",
      .series = {line("initial", "reference", std::move(first_error)),
                 line("final", "estimate", std::move(last_error))}};
  return {3,
          "Temperature tracking: initial and final controller",
          "A fixed PID lags where the wire takes up or gives off latent heat; the adaptive "
          "minimum-variance controller with gain scheduling does not. Same thermocouple for both.",
          {std::move(tracking), std::move(errors)}};
}

// Figure 4

Panel slice_panel(const fits::PreisachWire& wire, double stress_Pa) {
  std::string data = "$data << EOD\n";
  for (int hot = 25; hot <= 125; hot += 2) {
    for (int cold = 25; cold <= 125; cold += 2) {
      const double F = cold <= hot
                           ? wire.increment(hot + zero_degC_K, cold + zero_degC_K, stress_Pa)
                           : std::numeric_limits<double>::quiet_NaN();
      data += fmt::format("{} {} {}\n", cold, hot, report::plotted(100 * F));
    }
    data += "\n";
  }
  data += "EOD\n";
  const std::string settings =
      "set view 58,318,1.1\nset xyplane 0\nset zrange [0:4]\nset cbrange [0:4]\nset border 31\n"
      "set label 'F in %' at screen 0.02,0.82\nset palette defined (0 '#f2f6fa', 2 '#7fb2de', 4 "
      "'#0059b3')\n"
      "unset colorbox\nset xtics 50,25,125 offset 0,-0.3\nset ytics 50,25,125 offset 0,-0.3\n";
  return {.title = fmt::format("{:.0f} MPa", stress_Pa * 1e-6),
          .half_width = true,
          .height = 400,
          .x = {},
          .svg = report::draw_surface({500, 400, "β in °C", "α in °C"}, data, settings,
                                      {"$data using 1:2:3 with pm3d notitle"})};
}

PaperFigure slices_figure() {
  const fits::PreisachFit fit = fit_003(hal::Family::ihyp, fits::StressShift::none);
  std::vector<Panel> panels;
  for (const double stress_MPa : {100.0, 125.0, 150.0, 175.0, 200.0}) {
    panels.push_back(slice_panel(fit.wire, 1e6 * stress_MPa));
  }
  return {4, "Slices of the identified F at 100 to 200 MPa",
          "Strain that comes back on cooling from α to β. Its flanks, where the wire converts on "
          "heating to α and where on cooling to β, move to higher temperatures with the stress.",
          std::move(panels)};
}

// Figure 5

/// The left and the right panel of one row of the paper's figure.
std::vector<Panel> validation_panels(const fits::PreisachWire& wire,
                                     const fits::PreisachWire& wire_of_003, bool dynamic) {
  const Validation v = validation_003(hal::Family::ihyp, wire, dynamic);
  const Validation of_003 = validation_003(hal::Family::ihyp, wire_of_003, dynamic);
  const std::string name = dynamic ? "dynamic load" : "static load";
  const auto of = [&](auto value) { return report::column_of(v.rows, value); };
  const auto percent = [](const std::vector<double>& strain) {
    return report::column_of(strain, [](double e) { return 100 * e; });
  };
  const Column time = of([](const LoopRow& r) { return r.time_s; });
  Panel drive{.title = name + ": temperature and stress",
              .caption = "RT, RS: reference; TT, TS: true.",
              .half_width = true,
              .height = 400,
              .x = {.label = "time in s"},
              .y = {.label = "temperature in °C", .min = 20, .max = 170},
              .right = {.label = "stress in MPa", .min = 0, .max = 220},
              .link = name};
  const auto add = [&](const char* label, const char* colour, Column y, double width, bool right) {
    drive.series.push_back({.name = label,
                            .colour = colour,
                            .x = time,
                            .y = std::move(y),
                            .right = right,
                            .width = width});
  };
  add("RT", "measured",
      of([](const LoopRow& r) { return r.reference.temperature_K - zero_degC_K; }), 3, false);
  add("TT", "reference", of([](const LoopRow& r) { return r.truth.temperature_K - zero_degC_K; }),
      1, false);
  add("RS", "faint", of([](const LoopRow& r) { return 1e-6 * r.reference.stress_Pa; }), 3, true);
  add("TS", "estimate", of([](const LoopRow& r) { return 1e-6 * r.truth.stress_Pa; }), 1, true);
  Panel strain{
      .title = name + ": strain",
      .caption = fmt::format("Root mean square: {:.1f} % of a 4 % stroke where stress switches "
                             "relays, {:.1f} % where it only weighs them anew (003 eq. 2).",
                             100 * v.rms, 100 * of_003.rms),
      .half_width = true,
      .height = 400,
      .x = {.label = "time in s"},
      .y = {.label = "strain in %"},
      .link = name,
      .series = {{.name = "simulated wire",
                  .colour = "reference",
                  .x = time,
                  .y = percent(v.strain),
                  .width = 3},
                 {.name = "eq. 2",
                  .colour = "measured",
                  .x = time,
                  .y = percent(of_003.model),
                  .dashed = true},
                 {.name = "model", .colour = "estimate", .x = time, .y = percent(v.model)}}};
  return {std::move(drive), std::move(strain)};
}

PaperFigure validation_figure() {
  const fits::PreisachFit fit = fit_003(hal::Family::ihyp, fits::StressShift::fitted);
  const fits::PreisachFit of_003 = fit_003(hal::Family::ihyp, fits::StressShift::none);
  std::vector<Panel> panels = validation_panels(fit.wire, of_003.wire, false);
  for (Panel& panel : validation_panels(fit.wire, of_003.wire, true)) {
    panels.push_back(std::move(panel));
  }
  return {
      5, "Validation: static and dynamic load",
      "The model follows every branch between maxima and minima; under a load that varies it needs "
      "a stress that switches relays.",
      std::move(panels)};
}

}  // namespace

std::vector<PaperFigure> figures_003() {
  return {relay_figure(), loop_figure(), slices_figure(), validation_figure()};
}

}  // namespace smaservo::figures
