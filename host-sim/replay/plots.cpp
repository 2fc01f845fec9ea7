#include "host-sim/replay/plots.hpp"

#include <cmath>
#include <fmt/format.h>

namespace smaservo::replay {
namespace {

constexpr const char* data_columns =
    "# time strain low high reference R R_model T T_reference M M+R I stress\n";

/// All points as a data block; time counts from the first one.
std::string data_block(const std::vector<report::PlotPoint>& points) {
  std::string text = fmt::format("$data << EOD\n{}", data_columns);
  for (const report::PlotPoint& p : points) {
    const double band = std::isnan(p.strain_sd_percent) ? 0 : 2 * p.strain_sd_percent;
    const double columns[] = {p.time_s - points.front().time_s,
                              p.strain_percent,
                              p.strain_percent - band,
                              p.strain_percent + band,
                              p.strain_ref_percent,
                              p.resistance_ohm,
                              p.resistance_model_ohm,
                              p.temperature_degC,
                              p.temperature_ref_degC,
                              p.martensite,
                              p.martensite + p.r_phase,
                              p.current_A,
                              p.stress_MPa};
    text += report::plotted_row(columns);
  }
  return text + "EOD\n";
}

/// Which of the optional curves have anything to show.
struct Shown {
  bool time, reference, resistance, temperature_ref, current;
};
Shown shown(const ReplayResult& result, const std::vector<report::PlotPoint>& points) {
  Shown s{result.timed, result.has_reference, false, false, false};
  for (const report::PlotPoint& p : points) {
    s.resistance = s.resistance || std::isfinite(p.resistance_ohm);
    s.temperature_ref = s.temperature_ref || std::isfinite(p.temperature_ref_degC);
    s.current = s.current || std::isfinite(p.current_A);
  }
  s.temperature_ref = s.temperature_ref && !result.open_loop;
  return s;
}

class Drawing {
 public:
  explicit Drawing(const ReplayResult& result)
      : points_(result.series.points()),
        shown_(shown(result, points_)),
        data_(data_block(points_)),
        x_label_(shown_.time ? "time in s" : "row") {}

  report::Plot strain() const {
    std::vector<std::string> curves{
        "$data using 1:3:4 with filledcurves lc rgb band title 'two standard deviations'"};
    if (shown_.reference) {
      curves.emplace_back("$data using 1:5 with lines lc rgb reference lw 2.5 title 'reference'");
    }
    curves.emplace_back("$data using 1:2 with lines lc rgb estimate title 'estimate'");
    return wide("Strain", "Elongation of the whole wire: long is martensite, short is austenite.",
                "strain in %", 320, "", curves);
  }

  report::Plot resistance() const {
    std::vector<std::string> curves;
    if (shown_.resistance) {
      curves.emplace_back("$data using 1:6 with lines lc rgb measured title 'measured'");
    }
    curves.emplace_back("$data using 1:7 with lines lc rgb estimate title 'expected by the model'");
    return wide("Resistance", "The measured one is what corrects the estimate.", "resistance in Ω",
                260, "", curves);
  }

  report::Plot temperature() const {
    std::vector<std::string> curves;
    if (shown_.temperature_ref) {
      curves.emplace_back("$data using 1:9 with lines lc rgb reference title 'reference'");
    }
    curves.emplace_back("$data using 1:8 with lines lc rgb estimate title 'wire'");
    return wide("Temperature", "Of the wire away from its clamps.", "temperature in °C", 260, "",
                curves);
  }

  report::Plot phases() const {
    return wide("Phases", "Fractions of the whole wire, stacked.", "fraction", 260,
                "set yrange [0:1]\n",
                {"$data using 1:(0):10 with filledcurves lc rgb '#4477aa' title 'martensite'",
                 "$data using 1:10:11 with filledcurves lc rgb '#ddaa33' title 'R-phase'",
                 "$data using 1:11:(1) with filledcurves lc rgb '#dd99a0' title 'austenite'"});
  }

  report::Plot inputs() const {
    std::vector<std::string> curves{
        "$data using 1:13 axes x1y2 with lines lc rgb reference title 'stress'"};
    std::string more =
        "set y2label 'stress in MPa'\nset y2tics\nset y2range [0:*]\nset yrange [0:*]\nset border "
        "11\n";
    const char* label = "";
    if (shown_.current) {
      label = "current in A";
      curves.emplace_back("$data using 1:12 with lines lc rgb estimate title 'current'");
    } else {
      more += "unset ytics\n";
    }
    return wide("Inputs", "What drives the wire.", label, 220, more, curves);
  }

  report::Plot strain_resistance() const {
    const char* ohm = shown_.resistance ? "6" : "7";
    return square("Strain over resistance",
                  "One resistance, several strains: what a straight line misses.",
                  "resistance in Ω", loop(ohm));
  }

  report::Plot strain_temperature() const {
    return square("Strain over temperature", "The hysteresis between heating and cooling.",
                  "temperature in °C", loop("8"));
  }

 private:
  std::vector<std::string> loop(const char* x) const {
    std::vector<std::string> curves;
    if (shown_.reference) {
      curves.push_back(
          fmt::format("$data using {}:5 with lines lc rgb reference lw 2.5 title 'reference'", x));
    }
    curves.push_back(
        fmt::format("$data using {}:2 with lines lc rgb estimate title 'estimate'", x));
    return curves;
  }

  report::Plot wide(const char* title, const char* caption, const char* y_label, int height,
                    const std::string& more, const std::vector<std::string>& curves) const {
    return {title, caption, false,
            report::draw({1000, height, x_label_, y_label}, data_,
                         "set rmargin at screen 0.93\n" + more, curves)};
  }
  report::Plot square(const char* title, const char* caption, const char* x_label,
                      const std::vector<std::string>& curves) const {
    return {title, caption, true,
            report::draw({500, 400, x_label, "strain in %"}, data_, "", curves)};
  }

  std::vector<report::PlotPoint> points_;
  Shown shown_;
  std::string data_;
  const char* x_label_;
};

}  // namespace

std::vector<report::Plot> draw_plots(const ReplayResult& result) {
  const Drawing drawing(result);
  return {
      drawing.strain(), drawing.resistance(),        drawing.temperature(),       drawing.phases(),
      drawing.inputs(), drawing.strain_resistance(), drawing.strain_temperature()};
}

}  // namespace smaservo::replay
