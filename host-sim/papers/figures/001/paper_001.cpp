// The figures of paper 001, by Table I and a voltage of ours (actuator_run.hpp).

#include <algorithm>
#include <fmt/format.h>
#include <string>

#include "host-sim/papers/figures/001/actuator_run.hpp"
#include "host-sim/papers/figures/figure.hpp"
#include "model/papers/actuators/actuator_file.hpp"
#include "model/units.hpp"

namespace smaservo::figures {
namespace {

using Params = papers::DuhemActuator<double>::Params;

constexpr const char* colours_001 = "heating = 0xb2182b\ncooling = 0x2166ac\n";

/// A curve in the colours_001 of its direction; column 8 is 1 while heating.
std::vector<std::string> by_direction(int x, int y) {
  return {fmt::format("$data using {}:($8 == 1 ? ${} : NaN) with lines lc rgb heating "
                      "title 'heating'",
                      x, y),
          fmt::format("$data using {}:($8 == 0 ? ${} : NaN) with lines lc rgb cooling "
                      "title 'cooling'",
                      x, y)};
}

std::string data_block(const std::vector<ActuatorSample>& run) {
  std::string text = "$data << EOD\n# t V T R_m strain stress R heating\n";
  for (std::size_t i = 0; i < run.size(); ++i) {
    const auto& out = run[i].output;
    const std::size_t next = std::min(i + 1, run.size() - 1);
    const bool heating = run[next].output.temperature_K > run[next - 1].output.temperature_K;
    text += fmt::format(
        "{} {} {} {} {} {} {} {}\n", report::plotted(run[i].time_s),
        report::plotted(run[i].voltage_V), report::plotted(out.temperature_K - zero_degC_K),
        report::plotted(out.martensite), report::plotted(100 * out.transformation_strain),
        report::plotted(out.stress_Pa / 1e6), report::plotted(out.resistance_ohm), heating ? 1 : 0);
  }
  return text + "EOD\n";
}

PaperFigure single(int number, const char* title, const char* caption, const report::Axes& axes,
                   const std::string& data, const std::string& more,
                   const std::vector<std::string>& curves) {
  const bool half = axes.width <= 500;
  return {number,
          title,
          caption,
          {{title, "", half, report::draw(axes, data, colours_001 + more, curves)}}};
}

/// Temperature over time with something else on an axis of its own.
PaperFigure over_time(int number, const char* title, const char* caption, const std::string& data,
                      const char* other_label, int other, const char* other_title) {
  const std::string more = fmt::format(
      "set border 11\nset y2tics nomirror\nset y2label \"{}\"\nset yrange [20:110]\n"
      "set arrow from graph 0, first 58 to graph 1, first 58 nohead dt 3 lc rgb '#666666'\n"
      "set arrow from graph 0, first 48 to graph 1, first 48 nohead dt 3 lc rgb '#666666'\n"
      "set label 'A_s' at graph 0.995, first 61 right\n"
      "set label 'M_s' at graph 0.995, first 45 right\n",
      other_label);
  return single(
      number, title, caption, {1000, 400, "time in s", "temperature in °C"}, data, more,
      {"$data using 1:3 with lines lc rgb heating title 'temperature'",
       fmt::format("$data using 1:{} axes x1y2 with lines dt 2 lc rgb measured title '{}'", other,
                   other_title)});
}

PaperFigure slopes_integrated(const Params& p) {
  std::string data = "$data << EOD\n";
  for (const MinorLoop& loop : minor_loops(p.kinetics)) {
    for (std::size_t i = 0; i < loop.cooling.size(); ++i) {
      data += fmt::format("{} {} {}\n", report::plotted(loop.temperature_K[i] - zero_degC_K),
                          report::plotted(loop.cooling[i]), report::plotted(loop.heating[i]));
    }
    data += "\n";
  }
  return single(7, "Integrals of Gaussians yield hysteresis loops",
                "The major loop and three minor ones, which turn at a quarter, half and three "
                "quarters: each cools down a scaled copy of the major curve and stays within.",
                {500, 400, "temperature in °C", "austenite fraction"}, data + "EOD\n",
                "set yrange [0:1.02]\n",
                {"$data using 1:3 with lines lc rgb heating title 'increasing'",
                 "$data using 1:2 with lines lc rgb cooling title 'decreasing'"});
}

PaperFigure strain_over_martensite(const Params& p) {
  std::string data = "$data << EOD\n";
  for (int i = 0; i <= 200; ++i) {
    const double martensite = i / 200.0;
    data += fmt::format("{} {} {}\n", report::plotted(martensite),
                        report::plotted(100 * p.bias.balanced_strain(martensite)),
                        report::plotted(100 * p.bias.smooth_strain(martensite)));
  }
  return single(11, "Strain over martensite fraction",
                "The branches of eq. 17 and the polynomial of eq. 18 lie on each other within "
                "0.035 % of strain; martensite yields near the right end.",
                {500, 400, "martensite fraction", "strain in %"}, data + "EOD\n",
                "set key inside left top vertical\n",
                {"$data using 1:2 with lines lc rgb reference lw 3 title 'balance, eq. 17'",
                 "$data using 1:3 with lines dt 2 lc rgb estimate title 'polynomial, eq. 18'"});
}

PaperFigure resistivities(const Params& p) {
  // Table I to the digits that it prints; the file says why they are not these.
  const Params printed = printed_resistivity(p);
  std::string data = "$data << EOD\n";
  for (double T = p.resistivity.lowest_K; T <= p.resistivity.highest_K; T += 0.5) {
    data += fmt::format("{} {} {} {}\n", report::plotted(T - zero_degC_K),
                        report::plotted(1e6 * p.resistivity.austenite(T, p.ambient_K)),
                        report::plotted(1e6 * p.resistivity.martensite(T, p.ambient_K)),
                        report::plotted(1e6 * printed.resistivity.martensite(T, p.ambient_K)));
  }
  return single(12, "Electrical resistivity of both phases over temperature",
                "Both are near 1 µΩm. With the polynomial's coefficients as printed, two digits "
                "each, martensite's would run away above 45 °C (dotted).",
                {500, 400, "temperature in °C", "resistivity in µΩm"}, data + "EOD\n",
                "set yrange [0.6:1.8]\nset key samplen 2\n",
                {"$data using 1:2 with lines lc rgb heating title 'austenite'",
                 "$data using 1:3 with lines lc rgb cooling title 'martensite'",
                 "$data using 1:4 with lines dt 3 lc rgb measured title 'printed α'"});
}

}  // namespace

std::vector<PaperFigure> figures_001() {
  const Params p = papers::load_actuator(std::string(papers::paper_001_actuator));
  const std::string data = data_block(run_actuator(p, paper_001_voltage));
  const auto loops = [&](int number, const char* title, const char* caption, const char* x_label,
                         const char* y_label, int x, int y) {
    return single(number, title, caption, {500, 400, x_label, y_label}, data, "",
                  by_direction(x, y));
  };
  return {
      over_time(4, "Input voltage and temperature",
                "Above A_s (58 °C, where the heat capacity grows sixfold) the temperature's slope "
                "falls; cooling, it falls below M_s (48 °C, with the convection).",
                data, "voltage in V", 2, "voltage"),
      over_time(5, "Temperature and transformation strain",
                "Strain falls only while the temperature rises and stands while it goes through "
                "the dead zone. Simulated here; the paper shows the measured strain.",
                data, "transformation strain in %", 5, "strain"),
      slopes_integrated(p),
      loops(9, "Martensite fraction over temperature",
            "The first swing goes around the major loop, from 1 on; at 24 °C a cooled wire is "
            "back at 0.91 only. Later swings turn within it.",
            "temperature in °C", "martensite fraction", 3, 4),
      strain_over_martensite(p),
      resistivities(p),
      loops(13, "Electrical resistance over temperature",
            "Austenite has the lower resistance. Cold, resistance rises steeply: austenite's "
            "resistivity does so near the ambient temperature.",
            "temperature in °C", "resistance in Ω", 3, 7),
      loops(14, "Transformation strain over temperature",
            "As martensite (figure 9), bent by figure 11.", "temperature in °C",
            "transformation strain in %", 3, 5),
      loops(15, "Transformation strain over resistance",
            "Heating and cooling lie a fifth of the stroke apart at one resistance, and "
            "where the "
            "strain stands, resistance still follows the temperature.",
            "resistance in Ω", "transformation strain in %", 7, 5)};
}

}  // namespace smaservo::figures
