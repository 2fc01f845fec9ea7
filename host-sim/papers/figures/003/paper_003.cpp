#include "host-sim/papers/figures/003/paper_003.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "host-sim/papers/figures/figure.hpp"
#include "model/units.hpp"

namespace smaservo::figures {
namespace {

using Lines = std::vector<std::string>;

constexpr const char* colours_003 = "heating = 0xcc0000\ncooling = 0x0044cc\n";

// Figure 2

/// The corners of a wire's staircase: from 120 °C down, up, and down again.
std::string staircase_data() {
  const double top = 120;
  auto path = papers::Staircase<double, 16>::cooled(top, top);
  for (const double to : {48.0, 100.0, 62.0, 90.0, 72.0}) {
    path.move(to, [](double, double, double, double) { return 0.0; });
  }
  // (β, α), along the border of what is martensite
  std::string corners;
  const auto corner = [&](double beta, double alpha) {
    corners += fmt::format("{} {}\n", beta, alpha);
  };
  path.each_settled([&](double /*sign*/, double hot, double cold) { corner(cold, hot); });
  corner(path.input, path.newest());
  corner(path.input, path.input);
  return fmt::format(
      "$martensite << EOD\n{}{} {}\nEOD\n$all << EOD\n30 30\n30 120\n120 120\nEOD\n"
      "$staircase << EOD\n{}EOD\n",
      corners, top, top, corners);
}

report::Plot relay_plot() {
  const std::string data =
      "$on << EOD\n30 0\n90 0\n90 1\n110 1\nEOD\n$off << EOD\n110 1\n50 1\n50 0\n30 0\nEOD\n";
  const std::string settings =
      "set yrange [-0.2:1.3]\nset ytics ('martensite' 0, 'austenite' 1)\n"
      "set xtics ('β' 50, 'α' 90)\nset arrow from 90,0.4 to 90,0.6 lc rgb heating lw 2\n"
      "set arrow from 50,0.6 to 50,0.4 lc rgb cooling lw 2\n";
  return {"one relay", "Austenite from α on, on heating; martensite again from β on, on cooling.",
          true,
          report::draw({500, 400, "temperature", ""}, data, colours_003 + settings,
                       {"$on with lines lc rgb heating lw 2 title 'heating'",
                        "$off with lines lc rgb cooling lw 2 title 'cooling'"})};
}

report::Plot plane_plot() {
  const std::string settings =
      "set xrange [30:120]\nset yrange [30:120]\nset size ratio 1\nset grid front\n"
      "set label 'martensite' at 68,108 front\n"
      "set label 'austenite' at 34,70 front\n";
  return {"all relays",
          "After 120, 48, 100, 62, 90 and 72 °C: the staircase between the two is the memory.",
          true,
          report::draw({500, 400, "β in °C", "α in °C"}, staircase_data(), colours_003 + settings,
                       {"$all with filledcurves closed lc rgb '#f5d0c0' notitle",
                        "$martensite with filledcurves closed lc rgb band notitle",
                        "$staircase with lines lc rgb estimate lw 2 notitle",
                        "x with lines lc rgb '#666666' title 'α = β'"})};
}

PaperFigure relay_figure() {
  return {2,
          "The relay, and the plane of all relays",
          "What the wire remembers are the corners of the staircase: the turning points that are "
          "still open.",
          {relay_plot(), plane_plot()}};
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
  std::string data = "$data << EOD\n# time reference initial final\n";
  for (std::size_t i = 0; i < initial.size(); i += 4) {
    data += fmt::format("{} {} {} {}\n", report::plotted(initial[i].time_s),
                        report::plotted(initial[i].reference.temperature_K - zero_degC_K),
                        report::plotted(initial[i].truth.temperature_K - zero_degC_K),
                        report::plotted(final_[i].truth.temperature_K - zero_degC_K));
  }
  data += "EOD\n";
  const auto error = [](const std::vector<LoopRow>& rows) { return tracking_error_K(rows, 2); };
  const report::Plot tracking{
      "temperature", "Reference and both runs, whose lines cover each other.", false,
      report::draw({1000, 320, "time in s", "temperature in °C"}, data, "",
                   {"$data using 1:2 with lines lc rgb measured lw 4 title 'reference'",
                    "$data using 1:3 with lines lc rgb reference title 'initial'",
                    "$data using 1:4 with lines lc rgb estimate title 'final'"})};
  const report::Plot errors{
      "tracking error",
      fmt::format(
          "Root mean square: initial {:.2f} K, final {:.2f} K; the fixed controller with the "
          "best gain for this very run {:.2f} K.",
          error(initial), error(final_), error(run_loop(setup, best, references))),
      false,
      report::draw({1000, 320, "time in s", "true less reference in K"}, data,
                   "set yrange [-2.5:2.5]\n",
                   {"$data using 1:($3-$2) with lines lc rgb reference title 'initial'",
                    "$data using 1:($4-$2) with lines lc rgb estimate title 'final'"})};
  return {3,
          "Temperature tracking: initial and final controller",
          "A fixed PID lags where the wire takes up or gives off latent heat; the adaptive "
          "minimum-variance controller with gain scheduling does not. Same thermocouple for both.",
          {tracking, errors}};
}

// Figure 4

report::Plot slice_plot(const fits::PreisachWire& wire, double stress_Pa) {
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
  return {fmt::format("{:.0f} MPa", stress_Pa * 1e-6), "", true,
          report::draw_surface({500, 400, "β in °C", "α in °C"}, data, settings,
                               {"$data using 1:2:3 with pm3d notitle"})};
}

PaperFigure slices_figure() {
  const fits::PreisachFit fit = fit_003(hal::Family::ihyp, fits::StressShift::none);
  std::vector<report::Plot> panels;
  for (const double stress_MPa : {100.0, 125.0, 150.0, 175.0, 200.0}) {
    panels.push_back(slice_plot(fit.wire, 1e6 * stress_MPa));
  }
  return {4, "Slices of the identified F at 100 to 200 MPa",
          "Strain that comes back on cooling from α to β. Its flanks, where the wire converts on "
          "heating to α and where on cooling to β, move to higher temperatures with the stress.",
          std::move(panels)};
}

// Figure 5

std::string validation_data(const Validation& v, const Validation& of_003) {
  std::string data = "$data << EOD\n# time RT TT RS TS strain model model_of_003\n";
  for (std::size_t i = 0; i < v.rows.size(); i += 5) {
    const LoopRow& row = v.rows[i];
    data +=
        fmt::format("{} {} {} {} {} {} {} {}\n", report::plotted(row.time_s),
                    report::plotted(row.reference.temperature_K - zero_degC_K),
                    report::plotted(row.truth.temperature_K - zero_degC_K),
                    report::plotted(1e-6 * row.reference.stress_Pa),
                    report::plotted(1e-6 * row.truth.stress_Pa), report::plotted(100 * v.strain[i]),
                    report::plotted(100 * v.model[i]), report::plotted(100 * of_003.model[i]));
  }
  return data + "EOD\n";
}

/// The left and the right panel of one row of 003's figure.
std::vector<report::Plot> validation_plots(const fits::PreisachWire& wire,
                                           const fits::PreisachWire& wire_of_003, bool dynamic) {
  const Validation v = validation_003(hal::Family::ihyp, wire, dynamic);
  const Validation of_003 = validation_003(hal::Family::ihyp, wire_of_003, dynamic);
  const std::string data = validation_data(v, of_003);
  const std::string name = dynamic ? "dynamic load" : "static load";
  const std::string settings =
      "set y2label 'stress in MPa'\nset y2tics\nset border 11\nset y2range [0:220]\n"
      "set yrange [20:170]\n";
  return {{name + ": temperature and stress", "RT, RS: reference; TT, TS: true.", true,
           report::draw({500, 400, "time in s", "temperature in °C"}, data, settings,
                        {"$data using 1:2 with lines lc rgb measured lw 3 title 'RT'",
                         "$data using 1:3 with lines lc rgb reference title 'TT'",
                         "$data using 1:4 axes x1y2 with lines lc rgb '#bbbbbb' lw 3 title 'RS'",
                         "$data using 1:5 axes x1y2 with lines lc rgb estimate title 'TS'"})},
          {name + ": strain",
           fmt::format("Root mean square: {:.1f} % of a 4 % stroke where stress switches relays, "
                       "{:.1f} % where it only weighs them anew (003 eq. 2).",
                       100 * v.rms, 100 * of_003.rms),
           true,
           report::draw({500, 400, "time in s", "strain in %"}, data, "",
                        {"$data using 1:6 with lines lc rgb reference lw 3 title 'simulated wire'",
                         "$data using 1:8 with lines lc rgb measured dt 2 title 'eq. 2'",
                         "$data using 1:7 with lines lc rgb estimate title 'model'"})}};
}

PaperFigure validation_figure() {
  const fits::PreisachFit fit = fit_003(hal::Family::ihyp, fits::StressShift::fitted);
  const fits::PreisachFit of_003 = fit_003(hal::Family::ihyp, fits::StressShift::none);
  std::vector<report::Plot> panels = validation_plots(fit.wire, of_003.wire, false);
  for (report::Plot& plot : validation_plots(fit.wire, of_003.wire, true)) {
    panels.push_back(std::move(plot));
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
