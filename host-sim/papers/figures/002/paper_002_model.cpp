#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <utility>

#include "host-sim/papers/figures/002/liang_rogers_002.hpp"
#include "host-sim/papers/figures/002/paper_002_parts.hpp"
#include "host-sim/papers/figures/002/position_loop_002.hpp"

namespace smaservo::figures::bench_002 {
namespace {

using report::Series;
using Observer = papers::StrainResistance<double>;

/// The four coefficients of the lines in the units of figures 8 and 23.
struct Coefficients {
  double heating_slope, heating_offset, cooling_slope, cooling_offset;
};

/// The coefficients of two lines, in mm per ohm and mm.
Coefficients coefficients(const papers::ResistanceLine<double>& heating,
                          const papers::ResistanceLine<double>& cooling, double martensite_ohm) {
  return {displacement_mm(heating.slope) / martensite_ohm, displacement_mm(heating.offset),
          displacement_mm(cooling.slope) / martensite_ohm, displacement_mm(cooling.offset)};
}

/// The coefficients over stress.
struct OverStress {
  std::vector<double> stresses_MPa;
  std::vector<Coefficients> lines;

  Series series(double Coefficients::* value, std::string name, const char* colour) const {
    return {.name = std::move(name),
            .colour = colour,
            .x = report::column(stresses_MPa),
            .y = report::column_of(lines, [&](const Coefficients& c) { return c.*value; })};
  }
};

OverStress fitted(const fits::StrainResistanceFit& fit) {
  OverStress all;
  for (const fits::LoadLevel& level : fit.levels) {
    all.stresses_MPa.push_back(1e-6 * level.stress_Pa);
    all.lines.push_back(coefficients(level.heating, level.cooling, fit.params.martensite_ohm));
  }
  return all;
}

template <class Lines>
OverStress over_stress(const fits::StrainResistanceFit& fit, Lines lines) {
  OverStress all;
  constexpr int steps = 100;
  const double low_Pa = fit.params.min_stress_Pa;
  for (int i = 0; i <= steps; ++i) {
    const double stress_Pa = low_Pa + (fit.params.max_stress_Pa - low_Pa) * i / steps;
    all.stresses_MPa.push_back(1e-6 * stress_Pa);
    all.lines.push_back(lines(stress_Pa));
  }
  return all;
}

OverStress polynomial(const fits::StrainResistanceFit& fit) {
  const Observer::Params& p = fit.params;
  return over_stress(fit, [&](double stress_Pa) {
    return coefficients(Observer::line(p.heating, p, stress_Pa),
                        Observer::line(p.cooling, p, stress_Pa), p.martensite_ohm);
  });
}

OverStress analytic(const fits::StrainResistanceFit& fit) {
  const Wire<double> w = wire().wire;
  const papers::LiangRogers<double>::Params kinetics = liang_rogers(w);
  const double ohm = w.material.martensite.resistivity_ohm_m * w.length_per_area_1_m();
  return over_stress(fit, [&](double stress_Pa) {
    const auto lines = papers::ResistanceLines<double>::at(kinetics, w.material, stress_Pa);
    return coefficients(lines.heating.line, lines.cooling.line, ohm);
  });
}

/// Two panels side by side, with slopes and offsets.
std::vector<report::Panel> coefficient_panels(const fits::StrainResistanceFit& fit,
                                              bool with_analytic) {
  struct Shown {
    const char* title;
    const char* y;
    double Coefficients::*heating, Coefficients::*cooling;
  };
  std::vector<report::Panel> panels;
  for (const Shown& shown :
       {Shown{"Slope", "slope in mm/Ω", &Coefficients::heating_slope, &Coefficients::cooling_slope},
        {"Offset", "offset in mm", &Coefficients::heating_offset, &Coefficients::cooling_offset}}) {
    std::vector<Series> all;
    for (const auto& [value, name] :
         {std::pair{shown.heating, "heating"}, {shown.cooling, "cooling"}}) {
      all.push_back(fitted(fit).series(value, fmt::format("{}, fitted", name), name));
      all.back().kind = report::Kind::points;
      all.push_back(polynomial(fit).series(value, fmt::format("{}, polynomial", name), name));
      if (with_analytic) {
        all.push_back(analytic(fit).series(value, fmt::format("{}, analytic", name), name));
        all.back().dashed = true;
      }
    }
    panels.push_back(half(shown.title, "stress in MPa", shown.y, std::move(all)));
  }
  return panels;
}

struct Simulation {
  identify::Run run;
  std::vector<double> strain;
  double error_percent;
};

Simulation simulation(const fits::StrainResistanceFit& fit, identify::Run run) {
  std::vector<double> strain = fits::estimate_strain(fit.params, run);
  const double error = mean_error_percent(strain, run);
  return {std::move(run), std::move(strain), error};
}

/// Displacement over time, and over resistance: two figures of the paper.
std::vector<PaperFigure> simulation_figures(const Simulation& s, int over_time, int over_ohm,
                                            const std::string& what, const std::string& caption) {
  const auto mm = [](const std::vector<double>& of) {
    return report::column_of(of, displacement_mm);
  };
  const auto series = [&](const std::vector<double>& over) {
    const report::Column x = report::column(over);
    return std::vector<Series>{{.name = "simulated wire",
                                .colour = "reference",
                                .x = x,
                                .y = mm(s.run.strain),
                                .width = 2},
                               {.name = "model", .colour = "estimate", .x = x, .y = mm(s.strain)}};
  };
  const std::string error = fmt::format("Mean error {:.1f} % of 4 %. {}", s.error_percent, caption);
  return {
      {over_time,
       "Simulation under " + what,
       error,
       {wide("Displacement over time", "time in s", mm_label, series(s.run.time_s))}},
      {over_ohm,
       "Displacement over resistance under " + what,
       caption,
       {wide("Displacement over resistance", ohm_label, mm_label, series(s.run.resistance_ohm))}}};
}

PaperFigure figure_21(const fits::StrainResistanceFit& fit) {
  const std::vector<LoopRow> loop = position_loop(shown_family, fit.params, 10, 1);
  double error = 0;
  for (const LoopRow& r : loop) {
    error += 100 * std::abs(r.estimate - r.strain) / 0.04 / static_cast<double>(loop.size());
  }
  const auto of = [&](auto value) { return report::column_of(loop, value); };
  const report::Column time = of([](const LoopRow& r) { return r.time_s; });
  const auto mm = [&](double LoopRow::* value) {
    return of([&](const LoopRow& r) { return displacement_mm(r.*value); });
  };
  report::Panel position = wide(
      "Position", "time in s", mm_label,
      {{.name = "desired", .colour = "measured", .x = time, .y = mm(&LoopRow::goal), .width = 2},
       {.name = "actual", .colour = "reference", .x = time, .y = mm(&LoopRow::strain), .width = 2},
       {.name = "estimated", .colour = "estimate", .x = time, .y = mm(&LoopRow::estimate)}});
  report::Panel load =
      wide("Load", "time in s", "stress in MPa",
           {{.name = "stress", .colour = "estimate", .x = time, .y = of([](const LoopRow& r) {
                                                                  return 1e-6 * r.stress_Pa;
                                                                })}});
  position.link = load.link = "time";
  return {21,
          "Position control on the estimate, with a bias spring",
          fmt::format("The loop holds the estimate; the estimate's mean error is {:.1f} % of 4 %.",
                      error),
          {std::move(position), std::move(load)}};
}

PaperFigure figure_22() {
  const Wire<double> w = wire().wire;
  std::vector<Series> series;
  for (const double stress_MPa : {15.0, 55.0, 95.0, 135.0, 175.0}) {
    for (const bool heats : {true, false}) {
      const auto loop = liang_rogers_loop(w, 1e6 * stress_MPa, heats);
      using Point = papers::ResistancePoint<double>;
      series.push_back(
          {.name = fmt::format("{:.0f} MPa", stress_MPa),
           .colour = shade_of(stress_MPa, heats),
           .x = report::column_of(loop, [](const Point& p) { return p.resistance; }),
           .y = report::column_of(loop, [](const Point& p) { return displacement_mm(p.strain); })});
    }
  }
  return {22,
          "Loops by the augmented Liang-Rogers model",
          "The same family as in figure 5, from cosines; heating red, cooling blue.",
          {wide("Resistance and displacement", ohm_label, mm_label, std::move(series))}};
}

}  // namespace

std::vector<PaperFigure> model_figures(const fits::StrainResistanceFit& fit) {
  std::vector<PaperFigure> all{
      {8, "Slope and offset of the lines over stress",
       "Cooling changes with the stress, heating hardly; polynomials of fourth order.",
       coefficient_panels(fit, false)},
      figure_21(fit),
      figure_22(),
      {23, "Coefficients of the lines: fitted, polynomials, analytic",
       "The analytic lines have the same trends from the wire's own temperatures and "
       "resistivities.",
       coefficient_panels(fit, true)}};
  const auto add = [&](identify::Run run, int over_time, int over_ohm, const char* what,
                       const char* caption) {
    const Simulation s = simulation(fit, std::move(run));
    std::ranges::move(simulation_figures(s, over_time, over_ohm, what, caption),
                      std::back_inserter(all));
  };
  add(validation_run(shown_family, hal::ConstantLoad{stress_Pa(0.49)}), 12, 16, "0.49 N",
      "Good except for the coldest martensite.");
  add(validation_run(shown_family, hal::ConstantLoad{stress_Pa(0.98)}), 13, 17, "0.98 N",
      "Good except for the coldest martensite.");
  const identify::Run sprung = validation_run(shown_family, spring());
  add(sprung, 14, 18, "a spring", "The lines change while the wire moves.");
  add(with_constant_stress(sprung), 15, 19, "a spring, with a constant load assumed",
      "The model takes the spring's greatest load for granted and sees no hysteresis where it is "
      "slack.");
  return all;
}

}  // namespace smaservo::figures::bench_002
