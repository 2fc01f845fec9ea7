#include "host-sim/identify/fit_plots.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include "host-sim/identify/fitted_wire.hpp"
#include "model/units.hpp"

namespace smaservo::identify {
namespace {

/// The time of every comparison in seconds; for settled states, their numbers.
std::vector<double> places(const Run& run) {
  const FitRun fit = thin_run(run);
  std::vector<double> all;
  double now_s = 0;
  std::size_t step = 0;
  for (const std::size_t after : fit.after) {
    for (; step <= after; ++step) {
      now_s += fit.dt_s.empty() ? 1 : fit.dt_s[step];
    }
    all.push_back(now_s);
  }
  return all;
}

/// All comparisons of a run as columns; NaN for quantities that a run does not have.
struct FitColumns {
  report::Column place, temperature, measured, model, residual, resistance, resistance_model;
  report::Column stress, stress_model;  ///< MPa
};

FitColumns columns_of(const FittedRun& run, const std::vector<double>& place,
                      double nominal_stroke) {
  const bool heat = run.kind == RunKind::calorimetry;
  const double factor = heat ? 1 : 100;
  const auto scaled = [&](const std::vector<double>& column, double by, double offset = 0) {
    std::vector<double> all(place.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < std::min(column.size(), all.size()); ++i) {
      all[i] = by * column[i] - offset;
    }
    return all;
  };
  std::vector<double> residual = scaled(run.strain_model, factor);
  for (std::size_t i = 0; i < residual.size() && i < run.strain_measured.size(); ++i) {
    residual[i] = (residual[i] - factor * run.strain_measured[i]) / (heat ? 1 : nominal_stroke);
  }
  for (std::size_t i = 0; i < std::min(run.stress_model_Pa.size(), residual.size()); ++i) {
    residual[i] = 1e-6 * (run.stress_model_Pa[i] - run.stress_measured_Pa[i]);
  }
  return {report::column(place),
          report::column(scaled(run.temperature_K, 1, zero_degC_K)),
          report::column(scaled(run.strain_measured, factor)),
          report::column(scaled(run.strain_model, factor)),
          report::column(std::move(residual)),
          report::column(scaled(run.resistance_measured, 1)),
          report::column(scaled(run.resistance_model, 1)),
          report::column(scaled(run.stress_measured_Pa, 1e-6)),
          report::column(scaled(run.stress_model_Pa, 1e-6))};
}

class RunDrawing {
 public:
  /// `role`: "run"; axes of plots of the same role and number are linked.
  RunDrawing(const FittedRun& fitted, const Run& run, std::string_view role, std::size_t number,
             double nominal_stroke)
      : run_(fitted),
        name_(file_name(fitted.name) + (role == "run" ? "" : fmt::format(", {}", role))),
        link_(fmt::format("{} {}", role, number)),
        columns_(columns_of(fitted, places(run), nominal_stroke)) {}

  std::vector<report::Panel> all() const {
    const FitColumns& c = columns_;
    std::vector<report::Panel> plots;
    const bool strain = run_.strain.count > 0;
    const bool resistance = run_.resistance.count > 0;
    switch (run_.kind) {
      case RunKind::calorimetry:
        return {curve("heat flow", "temperature", "heat flow in W/kg", c.temperature, c.measured,
                      c.model),
                residual("temperature", c.temperature, "model - measured in W/kg")};
      case RunKind::bath:
        if (strain) {
          plots.push_back(
              curve("strain", "temperature", "strain in %", c.temperature, c.measured, c.model));
          plots.push_back(residual("temperature", c.temperature, residual_label));
        }
        if (resistance) {
          plots.push_back(curve("resistance", "temperature", "resistance in Ω", c.temperature,
                                c.resistance, c.resistance_model));
        }
        break;
      case RunKind::imposed:
        return {curve("stress", "time", "stress in MPa", c.place, c.stress, c.stress_model),
                residual("time", c.place, "model - measured in MPa")};
      case RunKind::joule:
      case RunKind::settled: {
        const char* over = run_.kind == RunKind::joule ? "time" : "number of the state";
        plots.push_back(curve("strain", over, "strain in %", c.place, c.measured, c.model));
        plots.push_back(curve("resistance", over, "resistance in Ω", c.place, c.resistance,
                              c.resistance_model));
        plots.push_back(residual(over, c.place, residual_label));
        break;
      }
    }
    if (strain && resistance) {
      plots.push_back(loop());
    }
    return plots;
  }

 private:
  static constexpr const char* residual_label = "model - measured in % of the stroke";

  /// The fitted parameters of this run only, in words.
  std::string circumstances() const {
    const Circumstances<double>& c = run_.circumstances;
    std::string text;
    const bool imposed = run_.kind == RunKind::imposed;
    if (run_.kind == RunKind::joule || run_.kind == RunKind::settled || imposed) {
      text = fmt::format("Ambient {:.1f} °C, heat loss times {:.3f}. ", c.ambient_K - zero_degC_K,
                         c.loss);
    }
    if (run_.strain.count > 0 || imposed) {
      text += fmt::format("The run's zero of strain stands at {:.3f} %. ", 100 * c.strain_zero);
    }
    if (run_.resistance.count > 0) {
      text += fmt::format("Its resistance reads {:.4f} times the wire's.", c.resistance_gain);
    }
    return text;
  }

  static std::string unit(const std::string& over) {
    return over + (over == "temperature" ? " in °C" : over == "time" ? " in s" : "");
  }

  static report::Series measured_series(const report::Column& x, const report::Column& y) {
    return {.name = "measured", .colour = "reference", .x = x, .y = y, .width = 2.5};
  }
  static report::Series model_series(const report::Column& x, const report::Column& y) {
    return {.name = "model", .colour = "estimate", .x = x, .y = y};
  }

  report::Panel curve(const char* what, const char* over, const char* label,
                      const report::Column& x, const report::Column& measured,
                      const report::Column& model) const {
    report::Panel panel = plot(
        fmt::format("{}: {} over {}", name_, what, over),
        std::string_view(what) == "strain" || std::string_view(what) == "stress" ? circumstances()
                                                                                 : "",
        unit(over), label, x);
    panel.series = {measured_series(x, measured), model_series(x, model)};
    return panel;
  }

  report::Panel residual(const char* over, const report::Column& x, const char* label) const {
    report::Panel panel = plot(fmt::format("{}: what is left", name_),
                               "What the model does not explain.", unit(over), label, x);
    panel.height = panel.half_width ? panel.height : 220;
    panel.series = {model_series(x, columns_.residual)};
    panel.series.front().name = "model - measured";
    panel.rules = {{0, "", "measured"}};
    return panel;
  }

  report::Panel loop() const {
    const FitColumns& c = columns_;
    report::Panel panel{.title = fmt::format("{}: strain over resistance", name_),
                        .caption = "The relation that an observer uses.",
                        .half_width = true,
                        .height = 400,
                        .x = {.label = "resistance in Ω"},
                        .y = {.label = "strain in %"},
                        .follows = link_,
                        .series = {measured_series(c.resistance, c.measured),
                                   model_series(c.resistance_model, c.model)}};
    for (report::Series& series : panel.series) {
      series.at = run_.kind == RunKind::bath ? c.temperature : c.place;
    }
    return panel;
  }

  /// A plot over temperature is half as wide as one over time.
  report::Panel plot(std::string title, std::string caption, std::string x_label,
                     const char* y_label, const report::Column& x) const {
    const bool half = x == columns_.temperature;
    return {.title = std::move(title),
            .caption = std::move(caption),
            .half_width = half,
            .height = half ? 400 : 320,
            .x = {.label = std::move(x_label)},
            .y = {.label = y_label},
            .link = link_};
  }

  const FittedRun& run_;
  std::string name_;
  std::string link_;
  FitColumns columns_;
};

void draw(const std::vector<FittedRun>& fitted, const std::vector<Run>& runs, std::string_view role,
          double nominal_stroke, std::vector<report::Panel>& to) {
  for (std::size_t i = 0; i < fitted.size(); ++i) {
    for (report::Panel& panel : RunDrawing(fitted[i], runs[i], role, i, nominal_stroke).all()) {
      to.push_back(std::move(panel));
    }
  }
}

/// The observer's error in runs that a fit has not seen, over the stress of the run.
report::Panel judgement_panel(const FitResult& fit, const std::vector<Run>& runs) {
  std::vector<double> stress_MPa;
  for (const std::size_t i : fit.judgement.runs) {
    const std::vector<double>& stress_Pa = runs[i].stress_Pa;
    stress_MPa.push_back(1e-6 * std::accumulate(stress_Pa.begin(), stress_Pa.end(), 0.0) /
                         static_cast<double>(stress_Pa.size()));
  }
  const report::Column x = report::column(stress_MPa);
  report::Panel panel{.title = "Runs that were left out of a fit",
                      .caption =
                          "Mean error of the observer in each run, with a wire that was "
                          "fitted to the half of the runs without it.",
                      .half_width = true,
                      .height = 400,
                      .x = {.label = "mean stress in MPa"},
                      .y = {.label = "error in % of the stroke"}};
  for (const JudgedStructure& judged : fit.judgement.structures) {
    if (!judged.unseen.empty()) {
      std::vector<double> percent;
      std::ranges::transform(judged.unseen, std::back_inserter(percent),
                             [](double share) { return 100 * share; });
      panel.series.push_back(
          {.name = std::string(structure_name(judged.structure)),
           .colour = judged.structure == Structure::ordered ? "estimate" : "reference",
           .x = x,
           .y = report::column(percent)});
    }
  }
  return panel;
}

}  // namespace

std::vector<report::Panel> fit_panels(const FitResult& fit, const std::vector<Run>& runs) {
  std::vector<report::Panel> all;
  report::Panel judgement = judgement_panel(fit, runs);
  if (!judgement.series.empty()) {
    all.push_back(std::move(judgement));
  }
  draw(fit.runs, runs, "run", fit.wire.nominal_stroke, all);
  return all;
}

std::vector<report::Panel> held_out_panels(const std::vector<FittedRun>& fitted,
                                           const std::vector<Run>& runs, double nominal_stroke) {
  std::vector<report::Panel> all;
  draw(fitted, runs, "held out", nominal_stroke, all);
  return all;
}

}  // namespace smaservo::identify
