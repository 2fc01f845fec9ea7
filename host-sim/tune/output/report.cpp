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

/// Open loops over the frequency, one after the other with a gap between them.
struct Loci {
  std::vector<double> Hz, real, imaginary, dB, degrees;

  void add(double frequency_Hz, const std::complex<double>& L, double phase) {
    Hz.push_back(frequency_Hz);
    real.push_back(L.real());
    imaginary.push_back(L.imag());
    dB.push_back(20 * std::log10(std::abs(L)));
    degrees.push_back(phase);
  }
};

Loci loci(const std::vector<LinearLoop>& loops, std::size_t each) {
  Loci all;
  for (std::size_t i = 0; i < loops.size(); i += each) {
    double before = -90;
    for (const double omega : frequencies(loops[i].period_s)) {
      const std::complex<double> L = open_loop(loops[i], omega);
      double phase = std::arg(L) * 180 / std::numbers::pi;
      phase += 360 * std::round((before - phase) / 360);
      before = phase;
      all.add(omega / (2 * std::numbers::pi), L, phase);
    }
    all.add(nan, {nan, nan}, nan);
  }
  return all;
}

/// The circle that the locus must not enter for the required M_s.
report::Series circle() {
  std::vector<double> x, y;
  for (int i = 0; i <= 120; ++i) {
    const double angle = 2 * std::numbers::pi * i / 120;
    const double radius = 1 / AskedMargins{}.sensitivity;
    x.push_back(-1 + radius * std::cos(angle));
    y.push_back(radius * std::sin(angle));
  }
  return {.name = "Ms = 2",
          .colour = "reference",
          .x = report::column(std::move(x)),
          .y = report::column(std::move(y)),
          .width = 2};
}

constexpr const char* of_all = "uncertain wires";
constexpr const char* of_file = "the file’s wire";

/// Nyquist and Bode plots of a loop.
std::vector<report::Panel> loop_panels(const DesignedLoop& loop) {
  const std::string name = fmt::format("Loop of the {}: ", loop_text(loop.name));
  report::Panel nyquist{
      .title = name + "Nyquist",
      .caption = "Every state of every wire; none may enter the circle of Ms = 2 about -1.",
      .half_width = true,
      .height = 400,
      .x = {.label = "real part", .min = -2, .max = 1},
      .y = {.label = "imaginary part", .min = -2, .max = 0.5},
      .equal = true};
  report::Panel bode{.title = name + "Bode",
                     .caption = "Magnitude and phase of the open loop.",
                     .half_width = true,
                     .height = 400,
                     .x = {.label = "frequency in Hz", .log = true},
                     .y = {.label = "magnitude in dB", .min = -40, .max = 40},
                     .right = {.label = "phase in °", .min = -270, .max = -60}};
  const std::size_t each = std::max<std::size_t>(1, loop.loops.size() / 50);
  for (const bool file : {false, true}) {
    Loci all = file ? loci(loop.nominal_loops, 2) : loci(loop.loops, each);
    const report::Column Hz = report::column(std::move(all.Hz));
    const char* of = file ? of_file : of_all;
    nyquist.series.push_back({.name = of,
                              .colour = file ? "estimate" : "band",
                              .x = report::column(std::move(all.real)),
                              .y = report::column(std::move(all.imaginary)),
                              .at = Hz});
    bode.series.push_back({.name = fmt::format("magnitude, {}", of),
                           .colour = file ? "estimate" : "band",
                           .x = Hz,
                           .y = report::column(std::move(all.dB))});
    bode.series.push_back({.name = fmt::format("phase, {}", of),
                           .colour = file ? "reference" : "reference_band",
                           .x = Hz,
                           .y = report::column(std::move(all.degrees)),
                           .right = true});
  }
  nyquist.series.push_back(circle());
  bode.link = nyquist.follows = name;
  return {std::move(nyquist), std::move(bode)};
}

/// The steps of all runs over time, with the file's wire on top.
class StepPanels {
 public:
  explicit StepPanels(const ExpectedSteps& expected) : expected_(expected) {
    std::vector<double> time_s(expected.setpoint.size());
    for (std::size_t i = 0; i < time_s.size(); ++i) {
      time_s[i] = static_cast<double>(i) * expected.period_s;
    }
    time_ = report::column(std::move(time_s));
  }

  /// A panel of value(number) for all numbers of this column, for every run.
  template <class Value>
  report::Panel panel(const char* title, const char* label, int height,
                      std::vector<double> ExpectedRun::* column, Value value) const {
    report::Panel panel{.title = title,
                        .height = height,
                        .x = {.label = "time in s"},
                        .y = {.label = label},
                        .link = "time"};
    for (std::size_t i = expected_.runs.size(); i-- > 0;) {
      if (i == 0 && column == &ExpectedRun::strain) {
        panel.series.push_back({.name = "set-point",
                                .colour = "reference",
                                .kind = report::Kind::steps,
                                .x = time_,
                                .y = report::column_of(expected_.setpoint, value),
                                .width = 2});
      }
      panel.series.push_back({.name = i == 0 ? of_file : of_all,
                              .colour = i == 0 ? "estimate" : "band",
                              .x = time_,
                              .y = report::column_of(expected_.runs[i].*column, value)});
    }
    return panel;
  }

 private:
  const ExpectedSteps& expected_;
  report::Column time_;
};

/// Steps drawn from their own beginning: heating in one panel, cooling in another.
report::Panel overlay(const Tuned& t, bool heating) {
  double longest_s = 0;
  const double period_s = t.expected.period_s;
  struct Curves {
    std::vector<double> time_s, share;
  } all[2];
  for (std::size_t k = t.expected.runs.size(); k-- > 0;) {
    const ExpectedRun& r = t.expected.runs[k];
    Curves& curves = all[k == 0 ? 1 : 0];
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
        curves.time_s.push_back(at_s);
        curves.share.push_back((r.strain[row] - begin) / (s.to - begin));
      }
      curves.time_s.push_back(nan);
      curves.share.push_back(nan);
    }
  }
  report::Panel panel{.title = heating ? "Steps by heating" : "Steps by cooling",
                      .caption = "Share of the way to the set-point, from the moment it is given.",
                      .half_width = true,
                      .height = 400,
                      .x = {.label = "time in s", .min = 0, .max = longest_s},
                      .y = {.label = "share of the way", .min = 0, .max = 1.2},
                      .rules = {{1, "", "reference"}}};
  for (const std::size_t file : {0U, 1U}) {
    panel.series.push_back({.name = file == 1 ? of_file : of_all,
                            .colour = file == 1 ? "estimate" : "band",
                            .x = report::column(std::move(all[file].time_s)),
                            .y = report::column(std::move(all[file].share))});
  }
  return panel;
}

}  // namespace

void write_tune_report(const std::string& path, const Tuned& t, Units units) {
  const StepPanels steps(t.expected);
  std::vector<report::Panel> plots{
      steps.panel("Steps of the strain", "strain in %", 360, &ExpectedRun::strain,
                  [](double e) { return 100 * e; }),
      steps.panel("Temperature", "temperature in °C", 260, &ExpectedRun::temperature_K,
                  [](double K) { return K - zero_degC_K; }),
      steps.panel("Current", "current in mA", 220, &ExpectedRun::current_A,
                  [](double A) { return 1e3 * A; }),
      overlay(t, true), overlay(t, false)};
  plots.front().caption = "The device's own step, closed on wires of one temperature.";
  for (const DesignedLoop& loop : t.proposal.loops) {
    if (loop.possible) {
      for (report::Panel& panel : loop_panels(loop)) {
        plots.push_back(std::move(panel));
      }
    }
  }
  report::write_html(path, "tune " + t.wire,
                     report::listing_html("Proposal", tuned_text(t)) +
                         report::plots_html(plots, units) +
                         report::listing_html("Settings", tuned_toml(t)));
}

}  // namespace smaservo::tune
