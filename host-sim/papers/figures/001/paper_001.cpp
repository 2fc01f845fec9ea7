// The figures of paper 001, with the parameters of Table I and our own voltage (actuator_run.hpp).

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

using report::Column;
using report::Panel;
using report::Series;

/// A run as columns; `heats` is 1 while the temperature rises.
struct RunColumns {
  Column time, voltage, temperature, martensite, strain, resistance;
  std::vector<bool> heats;
};

RunColumns columns_of(const std::vector<ActuatorSample>& run) {
  const auto of = [&](auto value) { return report::column_of(run, value); };
  RunColumns all{of([](const ActuatorSample& s) { return s.time_s; }),
                 of([](const ActuatorSample& s) { return s.voltage_V; }),
                 of([](const ActuatorSample& s) { return s.output.temperature_K - zero_degC_K; }),
                 of([](const ActuatorSample& s) { return s.output.martensite; }),
                 of([](const ActuatorSample& s) { return 100 * s.output.transformation_strain; }),
                 of([](const ActuatorSample& s) { return s.output.resistance_ohm; }),
                 {}};
  for (std::size_t i = 0; i < run.size(); ++i) {
    const std::size_t next = std::min(i + 1, run.size() - 1);
    all.heats.push_back(run[next].output.temperature_K > run[next - 1].output.temperature_K);
  }
  return all;
}

/// A curve, each direction in its own colour.
std::vector<Series> by_direction(const RunColumns& run, const Column& x, const Column& y) {
  std::vector<Series> both;
  for (const bool heats : {true, false}) {
    std::vector<double> part = *y;
    for (std::size_t i = 0; i < part.size(); ++i) {
      part[i] = run.heats[i] == heats ? part[i] : report::as_the_data;
    }
    both.push_back({.name = heats ? "heating" : "cooling",
                    .colour = heats ? "heating" : "cooling",
                    .x = x,
                    .y = report::column(std::move(part)),
                    .at = run.time});
  }
  return both;
}

PaperFigure single(int number, const char* title, const char* caption, Panel panel) {
  panel.title = title;
  return {number, title, caption, {std::move(panel)}};
}

Panel square(const char* x_label, const char* y_label, std::vector<Series> series) {
  return {.title = "",
          .half_width = true,
          .height = 400,
          .x = {.label = x_label},
          .y = {.label = y_label},
          .series = std::move(series)};
}

/// Temperature over time, together with another quantity on its own axis.
PaperFigure over_time(int number, const char* title, const char* caption, const RunColumns& run,
                      const char* other_label, const Column& other, const char* other_title) {
  return single(
      number, title, caption,
      {.title = "",
       .height = 400,
       .x = {.label = "time in s"},
       .y = {.label = "temperature in °C", .min = 20, .max = 110},
       .right = {.label = other_label},
       .link = "time",
       .series = {{.name = "temperature", .colour = "heating", .x = run.time, .y = run.temperature},
                  {.name = other_title,
                   .colour = "measured",
                   .x = run.time,
                   .y = other,
                   .right = true,
                   .dashed = true}},
       .rules = {{58, "A_s = 58 °C", "ink"}, {48, "M_s = 48 °C", "faint"}}});
}

PaperFigure slopes_integrated(const Params& p) {
  std::vector<double> T, cooling, heating;
  for (const MinorLoop& loop : minor_loops(p.kinetics)) {
    for (const double K : loop.temperature_K) {
      T.push_back(K - zero_degC_K);
    }
    cooling.insert(cooling.end(), loop.cooling.begin(), loop.cooling.end());
    heating.insert(heating.end(), loop.heating.begin(), loop.heating.end());
    for (std::vector<double>* column : {&T, &cooling, &heating}) {
      column->push_back(report::as_the_data);  // a gap
    }
  }
  const Column x = report::column(std::move(T));
  Panel panel = square(
      "temperature in °C", "austenite fraction",
      {{.name = "increasing", .colour = "heating", .x = x, .y = report::column(std::move(heating))},
       {.name = "decreasing",
        .colour = "cooling",
        .x = x,
        .y = report::column(std::move(cooling))}});
  panel.y.min = 0;
  panel.y.max = 1.02;
  return single(7, "Integrals of Gaussians yield hysteresis loops",
                "The major loop and three minor ones, which turn at a quarter, half and three "
                "quarters: each cools down a scaled copy of the major curve and stays within.",
                std::move(panel));
}

PaperFigure strain_over_martensite(const Params& p) {
  std::vector<double> martensite;
  for (int i = 0; i <= 200; ++i) {
    martensite.push_back(i / 200.0);
  }
  const Column x = report::column(martensite);
  const auto strain = [&](auto of) {
    return report::column_of(martensite, [&](double z) { return 100 * of(z); });
  };
  return single(11, "Strain over martensite fraction",
                "The branches of eq. 17 and the polynomial of eq. 18 lie on each other within "
                "0.035 % of strain; martensite yields near the right end.",
                square("martensite fraction", "strain in %",
                       {{.name = "balance, eq. 17",
                         .colour = "reference",
                         .x = x,
                         .y = strain([&](double z) { return p.bias.balanced_strain(z); }),
                         .width = 3},
                        {.name = "polynomial, eq. 18",
                         .colour = "estimate",
                         .x = x,
                         .y = strain([&](double z) { return p.bias.smooth_strain(z); }),
                         .dashed = true}}));
}

PaperFigure resistivities(const Params& p) {
  // The coefficients with the digits printed in Table I; the file says why its own differ.
  const Params printed = printed_resistivity(p);
  std::vector<double> kelvin;
  for (double T = p.resistivity.lowest_K; T <= p.resistivity.highest_K; T += 0.5) {
    kelvin.push_back(T);
  }
  const Column x = report::column_of(kelvin, [](double T) { return T - zero_degC_K; });
  const auto micro = [&](auto of) {
    return report::column_of(kelvin, [&](double T) { return 1e6 * of(T); });
  };
  Panel panel =
      square("temperature in °C", "resistivity in µΩm",
             {{.name = "austenite", .colour = "heating", .x = x, .y = micro([&](double T) {
                                                                   return p.resistivity.austenite(
                                                                       T, p.ambient_K);
                                                                 })},
              {.name = "martensite", .colour = "cooling", .x = x, .y = micro([&](double T) {
                                                                    return p.resistivity.martensite(
                                                                        T, p.ambient_K);
                                                                  })},
              {.name = "printed α",
               .colour = "measured",
               .x = x,
               .y = micro([&](double T) { return printed.resistivity.martensite(T, p.ambient_K); }),
               .dashed = true}});
  panel.y.min = 0.6;
  panel.y.max = 1.8;
  return single(12, "Electrical resistivity of both phases over temperature",
                "Both are near 1 µΩm. With the polynomial's coefficients as printed, two digits "
                "each, martensite's would run away above 45 °C (dashed).",
                std::move(panel));
}

}  // namespace

std::vector<PaperFigure> figures_001() {
  const Params p = papers::load_actuator(std::string(papers::paper_001_actuator));
  const RunColumns run = columns_of(run_actuator(p, paper_001_voltage));
  const auto loops = [&](int number, const char* title, const char* caption, const char* x_label,
                         const char* y_label, const Column& x, const Column& y) {
    Panel panel = square(x_label, y_label, by_direction(run, x, y));
    panel.follows = "time";
    return single(number, title, caption, std::move(panel));
  };
  return {
      over_time(4, "Input voltage and temperature",
                "Above A_s (58 °C, where the heat capacity grows sixfold) the temperature's slope "
                "falls; cooling, it falls below M_s (48 °C, with the convection).",
                run, "voltage in V", run.voltage, "voltage"),
      over_time(5, "Temperature and transformation strain",
                "Strain falls only while the temperature rises and stands while it goes through "
                "the dead zone. Simulated here; the paper shows the measured strain.",
                run, "transformation strain in %", run.strain, "strain"),
      slopes_integrated(p),
      loops(9, "Martensite fraction over temperature",
            "The first swing goes around the major loop, from 1 on; at 24 °C a cooled wire is "
            "back at 0.91 only. Later swings turn within it.",
            "temperature in °C", "martensite fraction", run.temperature, run.martensite),
      strain_over_martensite(p),
      resistivities(p),
      loops(13, "Electrical resistance over temperature",
            "Austenite has the lower resistance. Cold, resistance rises steeply: austenite's "
            "resistivity does so near the ambient temperature.",
            "temperature in °C", "resistance in Ω", run.temperature, run.resistance),
      loops(14, "Transformation strain over temperature",
            "As martensite (figure 9), bent by figure 11.", "temperature in °C",
            "transformation strain in %", run.temperature, run.strain),
      loops(15, "Transformation strain over resistance",
            "Heating and cooling lie a fifth of the stroke apart at one resistance, and "
            "where the "
            "strain stands, resistance still follows the temperature.",
            "resistance in Ω", "transformation strain in %", run.resistance, run.strain)};
}

}  // namespace smaservo::figures
