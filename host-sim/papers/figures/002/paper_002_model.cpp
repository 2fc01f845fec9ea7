#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <tuple>
#include <utility>

#include "host-sim/papers/figures/002/liang_rogers_002.hpp"
#include "host-sim/papers/figures/002/paper_002_parts.hpp"
#include "host-sim/papers/figures/002/position_loop_002.hpp"

namespace smaservo::figures::bench_002 {
namespace {

using Rows = std::vector<std::vector<double>>;
using Observer = papers::StrainResistance<double>;

/// The four coefficients of the lines as figures 8 and 23 show them.
struct Coefficients {
  double heating_slope, heating_offset, cooling_slope, cooling_offset;
};

/// The coefficients of two lines, in mm per ohm and mm.
Coefficients coefficients(const papers::ResistanceLine<double>& heating,
                          const papers::ResistanceLine<double>& cooling, double martensite_ohm) {
  return {displacement_mm(heating.slope) / martensite_ohm, displacement_mm(heating.offset),
          displacement_mm(cooling.slope) / martensite_ohm, displacement_mm(cooling.offset)};
}

std::vector<double> row(double stress_Pa, const Coefficients& c) {
  return {1e-6 * stress_Pa, c.heating_slope, c.heating_offset, c.cooling_slope, c.cooling_offset};
}

std::string fitted_block(const fits::StrainResistanceFit& fit) {
  Rows rows;
  for (const fits::LoadLevel& level : fit.levels) {
    rows.push_back(row(level.stress_Pa,
                       coefficients(level.heating, level.cooling, fit.params.martensite_ohm)));
  }
  return data_block("fitted", rows);
}

template <class Lines>
std::string over_stress_block(const std::string& name, const fits::StrainResistanceFit& fit,
                              Lines lines) {
  Rows rows;
  constexpr int steps = 100;
  const double low_Pa = fit.params.min_stress_Pa;
  for (int i = 0; i <= steps; ++i) {
    const double stress_Pa = low_Pa + (fit.params.max_stress_Pa - low_Pa) * i / steps;
    rows.push_back(row(stress_Pa, lines(stress_Pa)));
  }
  return data_block(name, rows);
}

std::string polynomial_block(const fits::StrainResistanceFit& fit) {
  const Observer::Params& p = fit.params;
  return over_stress_block("polynomial", fit, [&](double stress_Pa) {
    return coefficients(Observer::line(p.heating, p, stress_Pa),
                        Observer::line(p.cooling, p, stress_Pa), p.martensite_ohm);
  });
}

std::string analytic_block(const fits::StrainResistanceFit& fit) {
  const Wire<double> w = wire().wire;
  const papers::LiangRogers<double>::Params kinetics = liang_rogers(w);
  const double ohm = w.material.martensite.resistivity_ohm_m * w.length_per_area_1_m();
  return over_stress_block("analytic", fit, [&](double stress_Pa) {
    const auto lines = papers::ResistanceLines<double>::at(kinetics, w.material, stress_Pa);
    return coefficients(lines.heating.line, lines.cooling.line, ohm);
  });
}

/// Two panels side by side: slopes and offsets.
std::vector<report::Plot> coefficient_panels(const std::string& data, bool analytic) {
  struct Panel {
    const char* title;
    const char* y;
    int heating, cooling;
  };
  std::vector<report::Plot> panels;
  for (const Panel& panel :
       {Panel{"Slope", "slope in mm/Ω", 2, 4}, {"Offset", "offset in mm", 3, 5}}) {
    std::vector<std::string> curves;
    for (const auto& [column, name, colour] :
         {std::tuple{panel.heating, "heating", red}, {panel.cooling, "cooling", blue}}) {
      curves.push_back(
          fmt::format("$fitted using 1:{} with points pt 7 lc rgb {} title '{}, fitted'", column,
                      colour, name));
      curves.push_back(fmt::format("$polynomial using 1:{} with lines lc rgb {} title 'polynomial'",
                                   column, colour));
      if (analytic) {
        curves.push_back(fmt::format(
            "$analytic using 1:{} with lines dt 2 lc rgb {} title 'analytic'", column, colour));
      }
    }
    panels.push_back(
        half(panel.title, "stress in MPa", panel.y, data, curves, "set key maxrows 3\n"));
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

/// Displacement over time, and over resistance: two of the paper's figures.
std::vector<PaperFigure> simulation_figures(const Simulation& s, int over_time, int over_ohm,
                                            const std::string& what, const std::string& caption) {
  Rows rows;
  for (std::size_t i = 0; i < s.strain.size(); ++i) {
    rows.push_back({s.run.time_s[i], s.run.resistance_ohm[i], displacement_mm(s.run.strain[i]),
                    displacement_mm(s.strain[i])});
  }
  const std::string data = data_block("data", rows);
  const auto curves = [](int x) {
    return std::vector<std::string>{
        fmt::format("$data using {}:3 with lines lc rgb reference lw 2 title 'simulated wire'", x),
        fmt::format("$data using {}:4 with lines lc rgb estimate title 'model'", x)};
  };
  const std::string error = fmt::format("Mean error {:.1f} % of 4 %. {}", s.error_percent, caption);
  return {{over_time,
           "Simulation under " + what,
           error,
           {wide("Displacement over time", "time in s", mm_label, data, curves(1))}},
          {over_ohm,
           "Displacement over resistance under " + what,
           caption,
           {wide("Displacement over resistance", ohm_label, mm_label, data, curves(2))}}};
}

PaperFigure figure_21(const fits::StrainResistanceFit& fit) {
  const std::vector<LoopRow> loop = position_loop(shown_family, fit.params, 10, 1);
  Rows rows;
  double error = 0;
  for (const LoopRow& r : loop) {
    rows.push_back({r.time_s, displacement_mm(r.goal), displacement_mm(r.strain),
                    displacement_mm(r.estimate), 1e-6 * r.stress_Pa});
    error += 100 * std::abs(r.estimate - r.strain) / 0.04 / static_cast<double>(loop.size());
  }
  const std::string data = data_block("data", rows);
  return {21,
          "Position control on the estimate, with a bias spring",
          fmt::format("The loop holds the estimate; the estimate's mean error is {:.1f} % of 4 %.",
                      error),
          {wide("Position", "time in s", mm_label, data,
                {"$data using 1:2 with lines lc rgb measured lw 2 title 'desired'",
                 "$data using 1:3 with lines lc rgb reference lw 2 title 'actual'",
                 "$data using 1:4 with lines lc rgb estimate title 'estimated'"}),
           wide("Load", "time in s", "stress in MPa", data,
                {"$data using 1:5 with lines lc rgb estimate notitle"})}};
}

PaperFigure figure_22() {
  const Wire<double> w = wire().wire;
  std::string data;
  std::vector<std::string> curves;
  for (const double stress_MPa : {15.0, 55.0, 95.0, 135.0, 175.0}) {
    for (const bool heats : {true, false}) {
      Rows rows;
      for (const papers::ResistancePoint<double>& point :
           liang_rogers_loop(w, 1e6 * stress_MPa, heats)) {
        rows.push_back({point.resistance, displacement_mm(point.strain)});
      }
      const std::string name = fmt::format("{}{:.0f}", heats ? "h" : "c", stress_MPa);
      data += data_block(name, rows);
      const auto shade = static_cast<int>(225 - stress_MPa);
      curves.push_back(
          heats
              ? fmt::format("${} using 1:2 with lines lc rgb '#{:02x}3020' notitle", name,
                            255 - shade / 2)
              : fmt::format("${} using 1:2 with lines lc rgb '#{:02x}{:02x}ff' title '{:.0f} MPa'",
                            name, shade, shade, stress_MPa));
    }
  }
  return {22,
          "Loops by the augmented Liang-Rogers model",
          "The same family as in figure 5, from cosines; heating red, cooling blue.",
          {wide("Resistance and displacement", ohm_label, mm_label, data, curves)}};
}

}  // namespace

std::vector<PaperFigure> model_figures(const fits::StrainResistanceFit& fit) {
  std::vector<PaperFigure> all{
      {8, "Slope and offset of the lines over stress",
       "Cooling changes with the stress, heating hardly; polynomials of fourth order.",
       coefficient_panels(fitted_block(fit) + polynomial_block(fit), false)},
      figure_21(fit),
      figure_22(),
      {23, "Coefficients of the lines: fitted, polynomials, analytic",
       "The analytic lines have the same trends from the wire's own temperatures and "
       "resistivities.",
       coefficient_panels(fitted_block(fit) + polynomial_block(fit) + analytic_block(fit), true)}};
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
