#include <fmt/format.h>
#include <utility>

#include "host-sim/papers/figures/000/paper_000_drawing.hpp"
#include "model/units.hpp"
#include "model/wire/three_phase/ihyp.hpp"

namespace smaservo::figures {
namespace paper_000 {
namespace {

PaperFigure figure_1() {
  const CalorimetryRun run = simulated_calorimetry();
  const Peaks at = peaks(run);
  const Column T = degC(run.temperature_K);
  const struct {
    const char* title;
    report::Axis y;
    Column values;
  } rows[] = {{"heat flow", axis("heat flow in W/kg", -260, 260), run.transforming_W_kg},
              {"strain", axis(strain_axis, -0.2, 4.3), times(100, run.strain)},
              {"specific resistance", axis(resistivity_axis, 0.89, 1.03),
               times(1e6, run.resistivity_ohm_m)}};
  PaperFigure figure{
      1,
      "Heat flow, strain and specific resistance",
      fmt::format("Simulated wire without stress. Heating: one transformation at {:.0f} "
                  "°C. Cooling: two, A2R at {:.0f} °C lifts the resistance, R2M at "
                  "{:.0f} °C the strain. Heat flow is without specific heat.",
                  at.m2a_K - zero_degC_K, at.a2r_K - zero_degC_K, at.r2m_K - zero_degC_K),
      {}};
  for (const auto& row : rows) {
    for (const bool heats : {true, false}) {
      const auto part = heats ? heating_part : cooling_part;
      report::Panel panel =
          half_panel(fmt::format("{}, {}", row.title, heats ? "heating" : "cooling"),
                     axis(temperature_axis, 20, 100), row.y,
                     {line(part(T, run.hottest()), part(row.values, run.hottest()),
                           heats ? heating_colour : cooling_colour, row.title)},
                     260);
      panel.rules =
          heats ? std::vector{marker(at.m2a_K)} : std::vector{marker(at.a2r_K), marker(at.r2m_K)};
      figure.panels.push_back(std::move(panel));
    }
  }
  return figure;
}

PaperFigure figure_2() {
  PaperFigure figure{
      2,
      "0 MPa and 250 MPa",
      "Simulated wire. At 250 MPa A2R no longer shows as a step of its own: martensite "
      "forms before R-phase can.",
      {}};
  for (const bool of_strain : {true, false}) {
    for (const double stress_MPa : {0.0, 250.0}) {
      const BathRun run = simulated_bath_run(stress_MPa);
      figure.panels.push_back(
          half_panel(fmt::format("{:.0f} MPa", stress_MPa), axis(temperature_axis, 20, 150),
                     axis(of_strain ? strain_axis : resistivity_axis),
                     cycle(degC(run.temperature_K),
                           of_strain ? times(100, run.strain) : times(1e6, run.resistivity_ohm_m),
                           run.hottest()),
                     300));
    }
  }
  return figure;
}

PaperFigure figure_5() {
  const BathRun bath = simulated_bath_run(function_stress_MPa);
  const std::vector<identify::ClassicFit> fits = transformation_functions(bath);
  const auto part = [&](const Column& column) { return heating_part(column, bath.hottest()); };
  const Column T = part(degC(bath.temperature_K));
  const Column wire = part(times(100, bath.strain));
  std::string errors;
  std::vector<report::Series> curves{line(T, wire, "#999999", "simulated wire", 5)};
  const char* const colours[] = {"#cc79a7", "#e69f00", "#56b4e9", "#009e73", "ink"};
  std::vector<report::Series> differences;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const Column fit = part(times(100, fits[i].strain));
    Column difference;
    for (std::size_t row = 0; row < fit.size(); ++row) {
      difference.push_back(fit[row] - wire[row]);
    }
    curves.push_back(line(T, fit, colours[i], std::string(fits[i].name), 1.6));
    differences.push_back(line(T, difference, colours[i], std::string(fits[i].name), 1.6));
    errors += fmt::format("{}{} {:.1f}", i == 0 ? "" : ", ", fits[i].name, 100 * fits[i].rms);
  }
  const report::Axis x = axis(temperature_axis, 75, 130);
  return {5,
          "Transformation functions",
          fmt::format("Each fitted to the same cycle of the simulated wire at {:.0f} MPa, heating "
                      "is drawn. Errors in % of the stroke, root mean square: {}. (Cycles of "
                      "measured Flexinol wires leave Bezier 0.8 to 1.1, ihyp 0.6 to 0.8.)",
                      function_stress_MPa, errors),
          {full_panel("strain on heating", x, axis(strain_axis), std::move(curves)),
           full_panel("function - simulated wire", x, axis("error of the strain in %"),
                      std::move(differences), 280)}};
}

PaperFigure figure_6() {
  const Isobar<double> m2a = isobar(paper_wire().kinetics.m2a, 0.0);
  Column z;
  Column sum;
  Column low;
  Column high;
  Column straight;
  for (int i = 1; i < 400; ++i) {
    const double x = i / 400.0;
    const IhypParts parts = ihyp_parts(m2a.shape, x);
    z.push_back(x);
    low.push_back(parts.initial / m2a.per_K);
    high.push_back(parts.target / m2a.per_K);
    straight.push_back(m2a.start_K + parts.line / m2a.per_K - zero_degC_K);
    sum.push_back(straight.back() + low.back() + high.back());
  }
  report::Panel parts_panel = half_panel(
      "the parts", axis("converted fraction z"), axis("parts of T in K, line in °C", -60, 160),
      {line(z, low, cooling_colour, "initial end"), line(z, high, heating_colour, "target end"),
       line(z, straight, r_phase_colour, "line")});
  parts_panel.rules = {{0, "", "faint"}};
  return {6,
          "The parts of ihyp",
          "T(z) is the sum of a line and two hyperbolas. The hyperbolas bend the ends of the line "
          "and are next to nothing elsewhere. M2A without stress.",
          {std::move(parts_panel),
           half_panel("the sum", axis("converted fraction z"), axis(temperature_axis, -60, 160),
                      {line(z, sum, "ink", "ihyp")})}};
}

PaperFigure figure_8() {
  const InnerLoop loop = inner_loop();
  const Column outer = degC(loop.temperature_K);
  report::Panel panel = full_panel("martensite", axis(temperature_axis, 20, 100),
                                   axis("martensite fraction", -0.02, 1.02),
                                   {line(outer, loop.heating, heating_colour, "M2A, outer curve"),
                                    line(outer, loop.cooling, cooling_colour, "A2M, outer curve"),
                                    line(degC(loop.back_K), loop.back, "ink", "A2M, scaled", 2.5)});
  panel.rules = {marker(loop.back_K.front())};
  return {8,
          "Scaling for an inner loop",
          "From the turning point on the outer cooling curve is scaled to the martensite that is "
          "there: it converts the same share of the austenite.",
          {std::move(panel)}};
}

/// One part of all bars: its name, its colour, and its height in each bar.
struct Part {
  const char* name;
  const char* colour;
};

/// Boxes around the temperatures, with the parts stacked.
template <class Bar, class Values>
report::Panel bars_panel(const std::vector<Bar>& bars, const std::vector<Part>& parts,
                         report::Axis x, Values values_of) {
  std::vector<report::Series> series;
  Column below(bars.size(), 0);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    Column corners, low, high;
    for (std::size_t i = 0; i < bars.size(); ++i) {
      const double T = bars[i].temperature_K - zero_degC_K;
      const double above = below[i] + values_of(bars[i])[k];
      corners.insert(corners.end(),
                     {T - 0.38 * bar_step_K, T + 0.38 * bar_step_K, report::as_the_data});
      low.insert(low.end(), {below[i], below[i], report::as_the_data});
      high.insert(high.end(), {above, above, report::as_the_data});
      below[i] = above;
    }
    series.push_back({.name = parts[k].name,
                      .colour = parts[k].colour,
                      .kind = report::Kind::area,
                      .x = report::column(std::move(corners)),
                      .y = report::column(std::move(high)),
                      .low = report::column(std::move(low))});
  }
  report::Panel panel = full_panel("fractions, step by step", std::move(x),
                                   axis("fraction", -0.02, 1.02), std::move(series));
  panel.rules = {{0, "", "measured"}, {1, "", "measured"}};
  return panel;
}

PaperFigure figure_9() {
  return {9,
          "Heating: M2A and R2A",
          fmt::format("Each bar is a step of {:.0f} K at {:.0f} MPa. Martensite counts from below, "
                      "R-phase from above; the two processes do not compete.",
                      bar_step_K, heating_bars_MPa),
          {bars_panel(heating_bars(),
                      {{"martensite", martensite_colour},
                       {"M2A", "#e88a9a"},
                       {"austenite", austenite_colour},
                       {"R2A", "#f5b5a8"},
                       {"R-phase", r_phase_colour}},
                      axis(temperature_axis), [](const HeatingBar& b) {
                        return Column{b.martensite, b.m2a, b.austenite, b.r2a, b.r_phase};
                      })}};
}

PaperFigure figure_10() {
  return {
      10,
      "Cooling: A2M, A2R and R2M",
      fmt::format("Each bar is a step of {:.0f} K at {:.0f} MPa. Yellow is austenite that A2M and "
                  "A2R would both take; what R2M takes counts as martensite in the next bar.",
                  bar_step_K, cooling_bars_MPa),
      {bars_panel(cooling_bars(),
                  {{"martensite", martensite_colour},
                   {"A2M", "#8fbbe8"},
                   {"A2M or A2R", "#f0dc82"},
                   {"austenite", austenite_colour},
                   {"A2R", "#a8dcae"},
                   {"R-phase", r_phase_colour},
                   {"R2M", "#5fc7c7"}},
                  axis(temperature_axis, 36, 75), [](const CoolingBar& b) {
                    return Column{b.martensite, b.a2m,     b.either, b.austenite,
                                  b.a2r,        b.r_phase, b.r2m};
                  })}};
}

}  // namespace

Column degC(const Column& kelvin) {
  Column all;
  for (const double T : kelvin) {
    all.push_back(T - zero_degC_K);
  }
  return all;
}

Column times(double factor, const Column& column) {
  Column all;
  for (const double value : column) {
    all.push_back(factor * value);
  }
  return all;
}

Column heating_part(const Column& all, std::size_t hottest) {
  return {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(hottest) + 1};
}
Column cooling_part(const Column& all, std::size_t hottest) {
  return {all.begin() + static_cast<std::ptrdiff_t>(hottest), all.end()};
}

report::Series line(Column x, Column y, std::string colour, std::string name, double width) {
  return {.name = std::move(name),
          .colour = std::move(colour),
          .x = report::column(std::move(x)),
          .y = report::column(std::move(y)),
          .width = width};
}

report::Series dashed(report::Series line) {
  line.dashed = true;
  return line;
}

std::vector<report::Series> cycle(const Column& x, const Column& y, std::size_t hottest,
                                  const std::string& heating, const std::string& cooling,
                                  double width) {
  return {line(heating_part(x, hottest), heating_part(y, hottest), heating_colour, heating, width),
          line(cooling_part(x, hottest), cooling_part(y, hottest), cooling_colour, cooling, width)};
}

report::Rule marker(double temperature_K) {
  return {temperature_K - zero_degC_K, "", "ink", true};
}

report::Axis axis(const char* label, double min, double max) {
  return {.label = label, .min = min, .max = max};
}

report::Panel half_panel(std::string title, report::Axis x, report::Axis y,
                         std::vector<report::Series> series, int height) {
  return {.title = std::move(title),
          .half_width = true,
          .height = height,
          .x = std::move(x),
          .y = std::move(y),
          .series = std::move(series)};
}

report::Panel full_panel(std::string title, report::Axis x, report::Axis y,
                         std::vector<report::Series> series, int height) {
  report::Panel panel =
      half_panel(std::move(title), std::move(x), std::move(y), std::move(series), height);
  panel.half_width = false;
  return panel;
}

}  // namespace paper_000

std::vector<PaperFigure> figures_000() {
  using namespace paper_000;
  std::vector<PaperFigure> all{figure_1(), figure_2(), figure_5(), figure_6(),
                               figure_8(), figure_9(), figure_10()};
  for (PaperFigure& figure : identified_figures()) {
    all.push_back(std::move(figure));
  }
  return all;
}

}  // namespace smaservo::figures
