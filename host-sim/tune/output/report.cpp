// A tuning as one HTML file.

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>

#include "host-sim/report/html.hpp"
#include "host-sim/tune/tune.hpp"
#include "model/units.hpp"

namespace smaservo::tune {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Frequencies of a picture: three decades up to Nyquist.
std::vector<double> frequencies(double period_s) {
  std::vector<double> all;
  const double nyquist = std::numbers::pi / period_s;
  constexpr int steps = 90;
  for (int i = 0; i <= steps; ++i) {
    all.push_back(nyquist * std::pow(10, 3.0 * (i - steps) / steps));
  }
  return all;
}

/// Every loop as a block of rows: Hz, real, imaginary, dB, degrees.
std::string locus(const char* name, const std::vector<LinearLoop>& loops, std::size_t each) {
  std::string text = fmt::format("${} << EOD\n", name);
  for (std::size_t i = 0; i < loops.size(); i += each) {
    double before = -90;
    for (const double omega : frequencies(loops[i].period_s)) {
      const std::complex<double> L = open_loop(loops[i], omega);
      double phase = std::arg(L) * 180 / std::numbers::pi;
      phase += 360 * std::round((before - phase) / 360);
      before = phase;
      text += fmt::format("{} {} {} {} {}\n", report::plotted(omega / (2 * std::numbers::pi)),
                          report::plotted(L.real()), report::plotted(L.imag()),
                          report::plotted(20 * std::log10(std::abs(L))), report::plotted(phase));
    }
    text += '\n';
  }
  return text + "EOD\n";
}

std::string loci(const DesignedLoop& loop) {
  const std::size_t each = std::max<std::size_t>(1, loop.loops.size() / 50);
  return locus("all", loop.loops, each) + locus("file", loop.nominal_loops, 2);
}

/// The circle that M_s must stay out of.
std::string circle() {
  std::string text = "$circle << EOD\n";
  for (int i = 0; i <= 120; ++i) {
    const double angle = 2 * std::numbers::pi * i / 120;
    const double radius = 1 / AskedMargins{}.sensitivity;
    text += fmt::format("{} {}\n", report::plotted(-1 + radius * std::cos(angle)),
                        report::plotted(radius * std::sin(angle)));
  }
  return text + "EOD\n";
}

report::Plot nyquist(const DesignedLoop& loop) {
  return {fmt::format("Loop of the {}: Nyquist", loop_text(loop.name)),
          "Every state of every wire; none may enter the circle of Ms = 2 about -1.", true,
          report::draw({500, 400, "real part", "imaginary part"}, loci(loop) + circle(),
                       "set xrange [-2:1]\nset yrange [-2:0.5]\n",
                       {"$all using 2:3 with lines lc rgb band title 'uncertain wires'",
                        "$file using 2:3 with lines lc rgb estimate title 'the file’s wire'",
                        "$circle using 1:2 with lines lc rgb reference lw 2 title 'Ms = 2'"})};
}

report::Plot bode(const DesignedLoop& loop) {
  return {fmt::format("Loop of the {}: Bode", loop_text(loop.name)),
          "Magnitude and phase of the open loop.", true,
          report::draw(
              {500, 400, "frequency in Hz", "magnitude in dB"}, loci(loop),
              "set logscale x\nset yrange [-40:40]\nset y2range [-270:-60]\nset y2tics -270,45\n"
              "set y2label 'phase in °'\nset border 11\nset format x '%g'\n",
              {"$all using 1:4 with lines lc rgb band title 'magnitude'",
               "$file using 1:4 with lines lc rgb estimate notitle",
               "$all using 1:5 axes x1y2 with lines lc rgb '#f6d5bd' title 'phase'",
               "$file using 1:5 axes x1y2 with lines lc rgb reference notitle"})};
}

/// A column for each run, thinned to what a picture shows.
std::string step_data(const Tuned& t) {
  const ExpectedSteps& e = t.expected;
  const std::size_t each = std::max<std::size_t>(1, e.setpoint.size() / 2500);
  std::string text = "$data << EOD\n";
  for (std::size_t i = 0; i < e.setpoint.size(); i += each) {
    text += fmt::format("{} {}", report::plotted(static_cast<double>(i) * e.period_s),
                        report::plotted(100 * e.setpoint[i]));
    for (const ExpectedRun& r : e.runs) {
      text += fmt::format(" {} {} {}", report::plotted(100 * r.strain[i]),
                          report::plotted(r.temperature_K[i] - zero_degC_K),
                          report::plotted(1e3 * r.current_A[i]));
    }
    text += '\n';
  }
  return text + "EOD\n";
}

/// One of the three columns of all runs, the file's wire on top.
report::Plot step_plot(const Tuned& t, const std::string& data, int column, const char* title,
                       const char* label, int height) {
  std::vector<std::string> curves;
  for (std::size_t i = t.expected.runs.size(); i-- > 1;) {
    curves.push_back(fmt::format("$data using 1:{} with lines lc rgb band {}",
                                 3 + 3 * i + static_cast<std::size_t>(column),
                                 i == 1 ? "title 'uncertain wires'" : "notitle"));
  }
  if (column == 0) {
    curves.emplace_back("$data using 1:2 with steps lc rgb reference lw 2 title 'set-point'");
  }
  curves.push_back(fmt::format(
      "$data using 1:{} with lines lc rgb estimate title 'the file’s wire'", 3 + column));
  return {title, column == 0 ? "The device's own step, closed on wires of one temperature." : "",
          false, report::draw({1000, height, "time in s", label}, data, "", curves)};
}

/// Each step from its own beginning: heating over cooling.
report::Plot overlay(const Tuned& t, bool heating) {
  std::string data = "$steps << EOD\n";
  double longest_s = 0;
  const double period_s = t.expected.period_s;
  for (std::size_t k = t.expected.runs.size(); k-- > 0;) {
    const ExpectedRun& r = t.expected.runs[k];
    for (const StepResponse& s : r.steps) {
      if ((s.to < s.from) != heating) {
        continue;
      }
      const double shown_s =
          std::max(0.1, 1.5 * t.worst[static_cast<std::size_t>(&s - r.steps.data())].settling_s);
      longest_s = std::max(longest_s, shown_s);
      const auto first = static_cast<std::size_t>(std::lround(s.begins_s / period_s));
      const double begin = r.strain[first];
      for (std::size_t i = 0; i < 500; ++i) {
        const double at_s = shown_s * static_cast<double>(i) / 500;
        const auto row =
            std::min(first + static_cast<std::size_t>(at_s / period_s), r.strain.size() - 1);
        data +=
            fmt::format("{} {} {}\n", report::plotted(at_s),
                        report::plotted((r.strain[row] - begin) / (s.to - begin)), k == 0 ? 0 : 1);
      }
      data += fmt::format("{} {} 0\n\n", report::plotted(nan), report::plotted(nan));
    }
  }
  data += "EOD\n";
  return {heating ? "Steps by heating" : "Steps by cooling",
          "Share of the way to the set-point, from the moment it is given.", true,
          report::draw(
              {500, 400, "time in s", "share of the way"}, data,
              fmt::format("set xrange [0:{}]\nset yrange [0:1.2]\n", report::plotted(longest_s)),
              {"$steps using 1:($3==1?$2:NaN) with lines lc rgb band title 'uncertain wires'",
               "$steps using 1:($3==0?$2:NaN) with lines lc rgb estimate title 'the file’s wire'",
               "1 with lines lc rgb reference notitle"})};
}

}  // namespace

void write_tune_report(const std::string& path, const Tuned& t) {
  std::vector<report::Plot> plots;
  const std::string data = step_data(t);
  plots.push_back(step_plot(t, data, 0, "Steps of the strain", "strain in %", 360));
  plots.push_back(step_plot(t, data, 1, "Temperature", "temperature in °C", 260));
  plots.push_back(step_plot(t, data, 2, "Current", "current in mA", 220));
  plots.push_back(overlay(t, true));
  plots.push_back(overlay(t, false));
  for (const DesignedLoop& loop : t.proposal.loops) {
    if (loop.possible) {
      plots.push_back(nyquist(loop));
      plots.push_back(bode(loop));
    }
  }
  report::write_html(path, "tune " + t.wire,
                     report::listing_html("Proposal", tuned_text(t)) + report::plots_html(plots) +
                         report::listing_html("Settings", tuned_toml(t)));
}

}  // namespace smaservo::tune
