#include <algorithm>
#include <fmt/format.h>
#include <initializer_list>
#include <iterator>
#include <utility>

#include "host-sim/papers/figures/002/paper_002_parts.hpp"
#include "model/units.hpp"

namespace smaservo::figures {
namespace bench_002 {
namespace {

using Rows = std::vector<std::vector<double>>;

/// Resistance and displacement on heating and on cooling, as two blocks.
std::string loop_blocks(const std::string& name, const std::vector<RigRow>& rows) {
  Rows heating, cooling;
  for (const RigRow& row : rows) {
    Rows& here = row.heats ? heating : cooling;
    Rows& other = row.heats ? cooling : heating;
    here.push_back({row.resistance_ohm, displacement_mm(row.strain)});
    if (!other.empty() && !other.back().empty()) {
      other.emplace_back();
    }
  }
  return data_block(name + "_heating", heating) + data_block(name + "_cooling", cooling);
}

std::vector<std::string> loop_curves(const std::string& name) {
  return {fmt::format("${}_heating using 1:2 with lines lc rgb {} title 'heating'", name, red),
          fmt::format("${}_cooling using 1:2 with lines lc rgb {} title 'cooling'", name, blue)};
}

PaperFigure figure_2() {
  const std::vector<RigRow> rows = major_loop(shown_family, 1);
  Rows over_time;
  for (const RigRow& row : rows) {
    over_time.push_back({row.time_s - rows.front().time_s, row.temperature_K - zero_degC_K});
  }
  return {
      2,
      "Major loop of resistance and displacement under 1 N",
      "The wire heats down a straight line; on cooling the R-phase raises the resistance first.",
      {half("Major loop", ohm_label, mm_label, loop_blocks("loop", rows), loop_curves("loop")),
       half("Temperature of the wire", "time in s", "temperature in °C",
            data_block("data", over_time),
            {"$data using 1:2 with lines lc rgb estimate notitle"})}};
}

PaperFigure figure_4() {
  const ThreePhaseParams<double> k = wire().wire.kinetics;
  const Surface<double> a2m = first_surface(k.a2m_a2r);
  const Surface<double> a2r = second_surface(k.a2m_a2r);
  Rows rows;
  for (double stress_MPa = 0; stress_MPa <= 200; stress_MPa += 5) {
    std::vector<double> row{stress_MPa};
    for (const Surface<double>* surface :
         std::initializer_list<const Surface<double>*>{&k.m2a, &a2m, &a2r}) {
      const Isobar<double> at = isobar(*surface, 1e6 * stress_MPa);
      row.push_back(at.start_K - zero_degC_K);
      row.push_back(at.start_K + 1 / at.per_K - zero_degC_K);
    }
    rows.push_back(row);
  }
  const auto curve = [](int column, const char* style, const char* name) {
    return fmt::format("$data using 1:{} with lines {} title '{}'", column, style, name);
  };
  return {4,
          "Transformation temperatures over stress",
          "Above 90 MPa martensite comes before the R-phase.",
          {wide("Transformation temperatures", "stress in MPa", "temperature in °C",
                data_block("data", rows),
                {curve(2, "lc rgb '#c0392b'", "A_s"), curve(3, "lc rgb '#c0392b' dt 2", "A_f"),
                 curve(4, "lc rgb '#2471a3'", "M_s"), curve(5, "lc rgb '#2471a3' dt 2", "M_f"),
                 curve(6, "lc rgb '#7f8c3d'", "R_s"), curve(7, "lc rgb '#7f8c3d' dt 2", "R_f")})}};
}

/// Newtons of a stress.
double load_N(double stress_Pa) {
  return stress_Pa * wire().wire.geometry.area_m2();
}

PaperFigure figure_5() {
  std::string data;
  std::vector<std::string> curves;
  for (const double stress_MPa : {15.0, 55.0, 95.0, 135.0, 175.0}) {
    const std::string name = fmt::format("at{:.0f}", stress_MPa);
    data += loop_blocks(name, major_loop(shown_family, load_N(1e6 * stress_MPa)));
    const auto shade = static_cast<int>(225 - stress_MPa);
    curves.push_back(fmt::format("${}_heating using 1:2 with lines lc rgb '#{:02x}3020' notitle",
                                 name, 255 - shade / 2));
    curves.push_back(
        fmt::format("${}_cooling using 1:2 with lines lc rgb '#{:02x}{:02x}ff' title "
                    "'{:.0f} MPa'",
                    name, shade, shade, stress_MPa));
  }
  return {5,
          "Loops under several constant loads",
          "A heavier load makes the wire longer and the loop narrower.",
          {wide("Major loops; heating red, cooling blue, dark under heavy loads", ohm_label,
                mm_label, data, curves)}};
}

PaperFigure figure_6(const MinorLoops& cooling, const MinorLoops& heating) {
  return {6,
          "Minor loops under 1.3 N",
          "After a reversal the curves leave flat and approach the major loop.",
          {half("Incomplete cooling", ohm_label, mm_label, loop_blocks("loop", cooling.rows),
                loop_curves("loop")),
           half("Incomplete heating", ohm_label, mm_label, loop_blocks("loop", heating.rows),
                loop_curves("loop"))}};
}

/// Two ends of a line in the plane of ohm and millimetres.
Rows line_ends(const papers::ResistanceLine<double>& line, double martensite_ohm) {
  Rows rows;
  for (const double strain : {0.005, 0.038}) {
    rows.push_back({martensite_ohm * (strain - line.offset) / line.slope, displacement_mm(strain)});
  }
  return rows;
}

PaperFigure figure_7(const fits::StrainResistanceFit& fit) {
  const double stress = stress_Pa(0.5);
  const double ohm = fit.params.martensite_ohm;
  const auto ends = [&](const papers::StressLine<double>& lines) {
    return line_ends(papers::StrainResistance<double>::line(lines, fit.params, stress), ohm);
  };
  std::vector<std::string> curves = loop_curves("loop");
  curves.emplace_back(
      "$heating using 1:2 with lines lc rgb '#c0392b' dt 2 lw 2 title 'heating line'");
  curves.emplace_back(
      "$cooling using 1:2 with lines lc rgb '#2471a3' dt 2 lw 2 title 'cooling line'");
  return {7,
          "Lines for heating and cooling under 0.5 N",
          "The lines leave out both ends of the transformation.",
          {wide("Linear functions", ohm_label, mm_label,
                loop_blocks("loop", major_loop(shown_family, 0.5)) +
                    data_block("heating", ends(fit.params.heating)) +
                    data_block("cooling", ends(fit.params.cooling)),
                curves)}};
}

PaperFigure figure_9(const fits::StrainResistanceFit& fit, const MinorLoops& cooling,
                     const MinorLoops& heating) {
  std::vector<report::Plot> panels;
  for (const MinorLoops* loops : {&cooling, &heating}) {
    const std::vector<double> strain = fits::estimate_strain(fit.params, loops->run);
    Rows measured, model;
    for (std::size_t i = 0; i < strain.size(); ++i) {
      measured.push_back({loops->run.resistance_ohm[i], displacement_mm(loops->run.strain[i])});
      model.push_back({loops->run.resistance_ohm[i], displacement_mm(strain[i])});
    }
    panels.push_back(half(loops == &cooling ? "Incomplete cooling" : "Incomplete heating",
                          ohm_label, mm_label,
                          data_block("measured", measured) + data_block("model", model),
                          {"$measured using 1:2 with lines lc rgb measured title 'simulated wire'",
                           "$model using 1:2 with lines lc rgb estimate title 'model'"}));
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

std::string data_block(const std::string& name, const std::vector<std::vector<double>>& rows) {
  std::string text = fmt::format("${} << EOD\n", name);
  for (const std::vector<double>& row : rows) {
    for (const double value : row) {
      text += report::plotted(value) + ' ';
    }
    text += '\n';
  }
  return text + "EOD\n";
}

report::Plot wide(std::string title, const std::string& x, const std::string& y,
                  const std::string& data, const std::vector<std::string>& curves,
                  const std::string& more) {
  return {std::move(title), "", false, report::draw({1000, 420, x, y}, data, more, curves)};
}

report::Plot half(std::string title, const std::string& x, const std::string& y,
                  const std::string& data, const std::vector<std::string>& curves,
                  const std::string& more) {
  return {std::move(title), "", true, report::draw({500, 400, x, y}, data, more, curves)};
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
