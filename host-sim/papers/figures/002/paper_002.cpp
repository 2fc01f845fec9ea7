#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <utility>

#include "host-sim/papers/figures/002/paper_002_parts.hpp"
#include "model/units.hpp"

namespace smaservo::figures {
namespace bench_002 {
namespace {

using report::Column;
using report::Series;

/// Displacement over resistance on heating and on cooling, with gaps where the direction changes.
struct Loop {
  std::vector<double> ohm, mm;
};
Loop branch_of(const std::vector<RigRow>& rows, bool heats) {
  Loop loop;
  for (const RigRow& row : rows) {
    const bool here = row.heats == heats;
    if (!here && (loop.ohm.empty() || std::isnan(loop.ohm.back()))) {
      continue;
    }
    loop.ohm.push_back(here ? row.resistance_ohm : report::as_the_data);
    loop.mm.push_back(here ? displacement_mm(row.strain) : report::as_the_data);
  }
  return loop;
}

Series branch(const std::vector<RigRow>& rows, bool heats, std::string name, std::string colour) {
  Loop loop = branch_of(rows, heats);
  return {.name = std::move(name),
          .colour = std::move(colour),
          .x = report::column(std::move(loop.ohm)),
          .y = report::column(std::move(loop.mm))};
}

std::vector<Series> loop_series(const std::vector<RigRow>& rows) {
  return {branch(rows, true, "heating", "heating"), branch(rows, false, "cooling", "cooling")};
}

PaperFigure figure_2() {
  const std::vector<RigRow> rows = major_loop(shown_family, 1);
  const auto of = [&](auto value) { return report::column_of(rows, value); };
  return {
      2,
      "Major loop of resistance and displacement under 1 N",
      "The wire heats down a straight line; on cooling the R-phase raises the resistance first.",
      {half("Major loop", ohm_label, mm_label, loop_series(rows)),
       half("Temperature of the wire", "time in s", "temperature in °C",
            {{.name = "wire",
              .colour = "estimate",
              .x = of([&](const RigRow& row) { return row.time_s - rows.front().time_s; }),
              .y = of([](const RigRow& row) { return row.temperature_K - zero_degC_K; })}})}};
}

PaperFigure figure_4() {
  const ThreePhaseParams<double> k = wire().wire.kinetics;
  const Surface<double> a2m = first_surface(k.a2m_a2r);
  const Surface<double> a2r = second_surface(k.a2m_a2r);
  std::vector<double> stresses_MPa;
  for (double stress_MPa = 0; stress_MPa <= 200; stress_MPa += 5) {
    stresses_MPa.push_back(stress_MPa);
  }
  const Column x = report::column(stresses_MPa);
  const struct {
    const Surface<double>* surface;
    const char *colour, *start, *finish;
  } processes[] = {{&k.m2a, "heating", "A_s", "A_f"},
                   {&a2m, "cooling", "M_s", "M_f"},
                   {&a2r, "#7f8c3d", "R_s", "R_f"}};
  std::vector<Series> series;
  for (const auto& process : processes) {
    const auto degC = [&](auto of) {
      return report::column_of(stresses_MPa, [&](double stress_MPa) {
        return of(isobar(*process.surface, 1e6 * stress_MPa)) - zero_degC_K;
      });
    };
    series.push_back({.name = process.start,
                      .colour = process.colour,
                      .x = x,
                      .y = degC([](const Isobar<double>& at) { return at.start_K; })});
    series.push_back({.name = process.finish,
                      .colour = process.colour,
                      .x = x,
                      .y = degC([](const Isobar<double>& at) { return at.start_K + 1 / at.per_K; }),
                      .dashed = true});
  }
  return {4,
          "Transformation temperatures over stress",
          "Above 90 MPa martensite comes before the R-phase.",
          {wide("Transformation temperatures", "stress in MPa", "temperature in °C",
                std::move(series))}};
}

/// The load of a stress, in newtons.
double load_N(double stress_Pa) {
  return stress_Pa * wire().wire.geometry.area_m2();
}

PaperFigure figure_5() {
  std::vector<Series> series;
  for (const double stress_MPa : {15.0, 55.0, 95.0, 135.0, 175.0}) {
    const std::vector<RigRow> rows = major_loop(shown_family, load_N(1e6 * stress_MPa));
    const std::string name = fmt::format("{:.0f} MPa", stress_MPa);
    for (const bool heats : {true, false}) {
      series.push_back(branch(rows, heats, name, shade_of(stress_MPa, heats)));
    }
  }
  return {5,
          "Loops under several constant loads",
          "A heavier load makes the wire longer and the loop narrower.",
          {wide("Major loops; heating red, cooling blue, dark under heavy loads", ohm_label,
                mm_label, std::move(series))}};
}

PaperFigure figure_6(const MinorLoops& cooling, const MinorLoops& heating) {
  return {6,
          "Minor loops under 1.3 N",
          "After a reversal the curves leave flat and approach the major loop.",
          {half("Incomplete cooling", ohm_label, mm_label, loop_series(cooling.rows)),
           half("Incomplete heating", ohm_label, mm_label, loop_series(heating.rows))}};
}

/// A line in the plane of resistance in ohm and displacement in millimetres.
Series line_of(const papers::ResistanceLine<double>& line, double martensite_ohm, const char* name,
               const char* colour) {
  std::vector<double> ohm, mm;
  for (const double strain : {0.005, 0.038}) {
    ohm.push_back(martensite_ohm * (strain - line.offset) / line.slope);
    mm.push_back(displacement_mm(strain));
  }
  return {.name = name,
          .colour = colour,
          .x = report::column(std::move(ohm)),
          .y = report::column(std::move(mm)),
          .width = 2,
          .dashed = true};
}

PaperFigure figure_7(const fits::StrainResistanceFit& fit) {
  const double stress = stress_Pa(0.5);
  const double ohm = fit.params.martensite_ohm;
  std::vector<Series> series = loop_series(major_loop(shown_family, 0.5));
  const auto add = [&](const papers::StressLine<double>& lines, const char* name,
                       const char* colour) {
    series.push_back(line_of(papers::StrainResistance<double>::line(lines, fit.params, stress), ohm,
                             name, colour));
  };
  add(fit.params.heating, "heating line", "heating");
  add(fit.params.cooling, "cooling line", "cooling");
  return {7,
          "Lines for heating and cooling under 0.5 N",
          "The lines leave out both ends of the transformation.",
          {wide("Linear functions", ohm_label, mm_label, std::move(series))}};
}

PaperFigure figure_9(const fits::StrainResistanceFit& fit, const MinorLoops& cooling,
                     const MinorLoops& heating) {
  std::vector<report::Panel> panels;
  for (const MinorLoops* loops : {&cooling, &heating}) {
    const std::vector<double> strain = fits::estimate_strain(fit.params, loops->run);
    const auto mm = [](const std::vector<double>& of) {
      return report::column_of(of, displacement_mm);
    };
    const Column ohm = report::column(loops->run.resistance_ohm);
    panels.push_back(half(
        loops == &cooling ? "Incomplete cooling" : "Incomplete heating", ohm_label, mm_label,
        {{.name = "simulated wire", .colour = "measured", .x = ohm, .y = mm(loops->run.strain)},
         {.name = "model", .colour = "estimate", .x = ohm, .y = mm(strain)}}));
  }
  return {9, "Transition model and minor loops under 1.3 N",
          "The model follows major and minor loops; this wire's own ways back to austenite are "
          "straighter.",
          std::move(panels)};
}

}  // namespace

double displacement_mm(double strain) {
  static const double length_mm = 1e3 * wire().wire.geometry.length_m;
  return length_mm * strain;
}

report::Panel wide(std::string title, const char* x, const char* y, std::vector<Series> series) {
  return {.title = std::move(title),
          .height = 420,
          .x = {.label = x},
          .y = {.label = y},
          .series = std::move(series)};
}

report::Panel half(std::string title, const char* x, const char* y, std::vector<Series> series) {
  report::Panel panel = wide(std::move(title), x, y, std::move(series));
  panel.half_width = true;
  panel.height = 400;
  return panel;
}

std::string shade_of(double stress_MPa, bool heats) {
  const auto shade = static_cast<int>(225 - stress_MPa);
  return heats ? fmt::format("#{:02x}3020", 255 - shade / 2)
               : fmt::format("#{:02x}{:02x}ff", shade, shade);
}

std::vector<PaperFigure> characterisation_figures(const fits::StrainResistanceFit& fit) {
  const MinorLoops cooling = minor_loops(shown_family, 1.3, true);
  const MinorLoops heating = minor_loops(shown_family, 1.3, false);
  return {figure_2(),    figure_4(),
          figure_5(),    figure_6(cooling, heating),
          figure_7(fit), figure_9(fit, cooling, heating)};
}

}  // namespace bench_002

std::vector<PaperFigure> figures_002() {
  const fits::StrainResistanceFit fit = bench_002::calibrate(bench_002::shown_family);
  std::vector<PaperFigure> all = bench_002::characterisation_figures(fit);
  std::ranges::move(bench_002::model_figures(fit), std::back_inserter(all));
  std::ranges::sort(all, {}, &PaperFigure::number);
  return all;
}

}  // namespace smaservo::figures
