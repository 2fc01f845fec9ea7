#include <fmt/format.h>
#include <utility>

#include "host-sim/papers/figures/000/paper_000_drawing.hpp"
#include "model/three_phase/ihyp.hpp"
#include "model/units.hpp"

namespace smaservo::figures {
namespace paper_000 {
namespace {

PaperFigure figure_1() {
  const CalorimetryRun run = simulated_calorimetry();
  const Peaks at = peaks(run);
  const std::string data =
      block("run", {degC(run.temperature_K), run.transforming_W_kg, times(100, run.strain),
                    times(1e6, run.resistivity_ohm_m)});
  const struct {
    const char *title, *label, *column, *range;
  } rows[] = {{"heat flow", "heat flow in W/kg", "2", "[-260:260]"},
              {"strain", strain_axis, "3", "[-0.2:4.3]"},
              {"specific resistance", resistivity_axis, "4", "[0.89:1.03]"}};
  PaperFigure figure{
      1,
      "Heat flow, strain and specific resistance",
      fmt::format("Simulated wire without stress. Heating: one transformation at {:.0f} "
                  "°C. Cooling: two, A2R at {:.0f} °C lifts the resistance, R2M at "
                  "{:.0f} °C the strain. Heat flow is without specific heat.",
                  at.m2a_K - zero_degC_K, at.a2r_K - zero_degC_K, at.r2m_K - zero_degC_K),
      {}};
  for (const auto& row : rows) {
    const std::string range = fmt::format("set xrange [20:100]\nset yrange {}\n", row.range);
    figure.panels.push_back(
        half_panel(fmt::format("{}, heating", row.title), "", temperature_axis, row.label, data,
                   range + marker(at.m2a_K),
                   {line("run", fmt::format("1:{} {}", row.column, heating_rows(run.hottest())),
                         heating_colour, "")},
                   260));
    figure.panels.push_back(
        half_panel(fmt::format("{}, cooling", row.title), "", temperature_axis, row.label, data,
                   range + marker(at.a2r_K) + marker(at.r2m_K),
                   {line("run", fmt::format("1:{} {}", row.column, cooling_rows(run.hottest())),
                         cooling_colour, "")},
                   260));
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
  for (const auto& [column, label] :
       {std::pair{"1:2", strain_axis}, std::pair{"1:3", resistivity_axis}}) {
    for (const double stress_MPa : {0.0, 250.0}) {
      const BathRun run = simulated_bath_run(stress_MPa);
      figure.panels.push_back(
          half_panel(fmt::format("{:.0f} MPa", stress_MPa), "", temperature_axis, label,
                     bath_block("run", run), "set xrange [20:150]\n",
                     {line("run", fmt::format("{} {}", column, heating_rows(run.hottest())),
                           heating_colour, "heating"),
                      line("run", fmt::format("{} {}", column, cooling_rows(run.hottest())),
                           cooling_colour, "cooling")},
                     300));
    }
  }
  return figure;
}

PaperFigure figure_5() {
  const BathRun bath = simulated_bath_run(function_stress_MPa);
  const std::vector<identify::ClassicFit> fits = transformation_functions(bath);
  std::vector<Column> columns{degC(bath.temperature_K), times(100, bath.strain)};
  std::string errors;
  std::vector<std::string> curves{
      line("run", "1:2 " + heating_rows(bath.hottest()), "'#999999'", "simulated wire", "lw 5")};
  const char* const colours[] = {"'#cc79a7'", "'#e69f00'", "'#56b4e9'", "'#009e73'", "'#111111'"};
  std::vector<std::string> differences;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    columns.push_back(times(100, fits[i].strain));
    differences.push_back(line("run",
                               fmt::format("1:(${0}-$2) {1}", i + 3, heating_rows(bath.hottest())),
                               colours[i], fits[i].name, "lw 1.6"));
    errors += fmt::format("{}{} {:.1f}", i == 0 ? "" : ", ", fits[i].name, 100 * fits[i].rms);
    curves.push_back(line("run", fmt::format("1:{} {}", i + 3, heating_rows(bath.hottest())),
                          colours[i], fits[i].name, "lw 1.6"));
  }
  const std::string data = block("run", columns);
  const char* settings = "set xrange [75:130]\nset key outside right center vertical\n";
  return {
      5,
      "Transformation functions",
      fmt::format("Each fitted to the same cycle of the simulated wire at {:.0f} MPa, heating "
                  "is drawn. Errors in % of the stroke, root mean square: {}. (Cycles of "
                  "measured Flexinol wires leave Bezier 0.8 to 1.1, ihyp 0.6 to 0.8.)",
                  function_stress_MPa, errors),
      {full_panel("strain on heating", "", temperature_axis, strain_axis, data, settings, curves),
       full_panel("function - simulated wire", "", temperature_axis, "error of the strain in %",
                  data, settings, differences, 280)}};
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
  return {
      6,
      "The parts of ihyp",
      "T(z) is the sum of a line and two hyperbolas. The hyperbolas bend the ends of the line "
      "and are next to nothing elsewhere. M2A without stress.",
      {half_panel("the parts", "", "converted fraction z", "parts of T in K, line in °C",
                  block("parts", {z, low, high, straight}),
                  "set yrange [-60:160]\nset key samplen 2\nset xzeroaxis lt 1 lc rgb '#999999'\n",
                  {line("parts", "1:2", cooling_colour, "initial end"),
                   line("parts", "1:3", heating_colour, "target end"),
                   line("parts", "1:4", r_phase_colour, "line")}),
       half_panel("the sum", "", "converted fraction z", temperature_axis, block("sum", {z, sum}),
                  "set yrange [-60:160]\n", {line("sum", "1:2", model_colour, "ihyp")})}};
}

PaperFigure figure_8() {
  const InnerLoop loop = inner_loop();
  const Column outer = degC(loop.temperature_K);
  return {
      8,
      "Scaling for an inner loop",
      "From the turning point on the outer cooling curve is scaled to the martensite that is "
      "there: it converts the same share of the austenite.",
      {full_panel("martensite", "", temperature_axis, "martensite fraction",
                  block("outer", {outer, loop.heating, loop.cooling}) +
                      block("back", {degC(loop.back_K), loop.back}),
                  "set xrange [20:100]\nset yrange [-0.02:1.02]\n" + marker(loop.back_K.front()),
                  {line("outer", "1:2", heating_colour, "M2A, outer curve"),
                   line("outer", "1:3", cooling_colour, "A2M, outer curve"),
                   line("back", "1:2", model_colour, "A2M, scaled", "lw 2.5")})}};
}

/// Boxes around the temperatures of `$bars`, from column `low` to the next one.
std::string boxes(int low, const char* colour, const char* title) {
  return fmt::format(
      "$bars using 1:1:($1-{0}):($1+{0}):{1}:{2} with boxxyerrorbars fs solid 1 border lc rgb "
      "'#444444' fc rgb {3} title '{4}'",
      0.38 * bar_step_K, low, low + 1, colour, title);
}

/// Columns of running sums, behind the temperature.
template <class Bar, class Parts>
std::string bars_block(const std::vector<Bar>& bars, Parts parts_of) {
  std::vector<Column> columns;
  for (const Bar& bar : bars) {
    Column row{bar.temperature_K - zero_degC_K, 0};
    for (const double part : parts_of(bar)) {
      row.push_back(row.back() + part);
    }
    columns.resize(row.size());
    for (std::size_t i = 0; i < row.size(); ++i) {
      columns[i].push_back(row[i]);
    }
  }
  return block("bars", columns);
}

constexpr const char* bar_settings =
    "set yrange [-0.02:1.02]\nset xtics 6\nset key outside right center vertical\n"
    "set arrow from graph 0, first 0 to graph 1, first 0 nohead dt 2\n"
    "set arrow from graph 0, first 1 to graph 1, first 1 nohead dt 2\n";

PaperFigure figure_9() {
  const std::string data = bars_block(heating_bars(), [](const HeatingBar& b) {
    return Column{b.martensite, b.m2a, b.austenite, b.r2a, b.r_phase};
  });
  return {
      9,
      "Heating: M2A and R2A",
      fmt::format("Each bar is a step of {:.0f} K at {:.0f} MPa. Martensite counts from below, "
                  "R-phase from above; the two processes do not compete.",
                  bar_step_K, heating_bars_MPa),
      {full_panel("fractions, step by step", "", temperature_axis, "fraction", data, bar_settings,
                  {boxes(6, r_phase_colour, "R-phase"), boxes(5, "'#f5b5a8'", "R2A"),
                   boxes(4, austenite_colour, "austenite"), boxes(3, "'#e88a9a'", "M2A"),
                   boxes(2, martensite_colour, "martensite")})}};
}

PaperFigure figure_10() {
  const std::string data = bars_block(cooling_bars(), [](const CoolingBar& b) {
    return Column{b.martensite, b.a2m, b.either, b.austenite, b.a2r, b.r_phase, b.r2m};
  });
  return {
      10,
      "Cooling: A2M, A2R and R2M",
      fmt::format("Each bar is a step of {:.0f} K at {:.0f} MPa. White is austenite that A2M and "
                  "A2R would both take; what R2M takes counts as martensite in the next bar.",
                  bar_step_K, cooling_bars_MPa),
      {full_panel("fractions, step by step", "", temperature_axis, "fraction", data,
                  std::string(bar_settings) + "set xrange [75:36]\n",
                  {boxes(8, "'#5fc7c7'", "R2M"), boxes(7, r_phase_colour, "R-phase"),
                   boxes(6, "'#a8dcae'", "A2R"), boxes(5, austenite_colour, "austenite"),
                   boxes(4, "'#ffffff'", "A2M or A2R"), boxes(3, "'#8fbbe8'", "A2M"),
                   boxes(2, martensite_colour, "martensite")})}};
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

std::string block(std::string_view name, const std::vector<Column>& columns) {
  std::string text = fmt::format("${} << EOD\n", name);
  for (std::size_t row = 0; row < columns.front().size(); ++row) {
    Column values;
    for (const Column& column : columns) {
      values.push_back(column[row]);
    }
    text += report::plotted_row(values);
  }
  return text + "EOD\n";
}

std::string bath_block(std::string_view name, const BathRun& run) {
  Column red;
  Column green;
  Column blue;
  for (const Phases<double>& z : run.phases) {
    red.push_back(255 * z.austenite());
    green.push_back(255 * z.r_phase);
    blue.push_back(255 * z.martensite);
  }
  return block(name, {degC(run.temperature_K), times(100, run.strain),
                      times(1e6, run.resistivity_ohm_m), resistances_ohm(run), red, green, blue});
}

std::string heating_rows(std::size_t hottest) {
  return fmt::format("every ::0::{}", hottest);
}
std::string cooling_rows(std::size_t hottest) {
  return fmt::format("every ::{}", hottest);
}

std::string line(std::string_view data, std::string_view columns, std::string_view colour,
                 std::string_view title, std::string_view more) {
  // gnuplot wants `every` before `using`.
  const std::size_t every = columns.find(" every");
  const std::string_view rows = every == std::string_view::npos ? "" : columns.substr(every);
  const std::string key = title.empty() ? "notitle" : fmt::format("title '{}'", title);
  return fmt::format("${}{} using {} with lines lc rgb {} {} {}", data, rows,
                     columns.substr(0, every), colour, more.empty() ? "lw 1.8" : more, key);
}

std::string marker(double temperature_K) {
  return fmt::format("set arrow from {0:.1f}, graph 0 to {0:.1f}, graph 1 nohead dt 2\n",
                     temperature_K - zero_degC_K);
}

report::Plot half_panel(std::string title, std::string caption, const char* x_label,
                        const char* y_label, const std::string& data, const std::string& more,
                        const std::vector<std::string>& curves, int height) {
  return {std::move(title), std::move(caption), true,
          report::draw({500, height, x_label, y_label}, data, more, curves)};
}

report::Plot full_panel(std::string title, std::string caption, const char* x_label,
                        const char* y_label, const std::string& data, const std::string& more,
                        const std::vector<std::string>& curves, int height) {
  return {std::move(title), std::move(caption), false,
          report::draw({1000, height, x_label, y_label}, data, more, curves)};
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
