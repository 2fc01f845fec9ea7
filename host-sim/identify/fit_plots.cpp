#include "host-sim/identify/fit_plots.hpp"

#include <fmt/format.h>
#include <limits>
#include <utility>

#include "host-sim/identify/fitted_wire.hpp"
#include "model/units.hpp"

namespace smaservo::identify {
namespace {

/// The time of every comparison in seconds; of settled states, their number.
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

/// All comparisons as a data block, "NaN" for what a run does not have.
std::string data_block(const FittedRun& run, const std::vector<double>& place,
                       double nominal_stroke) {
  const bool heat = run.kind == RunKind::calorimetry;
  const auto at = [](const std::vector<double>& column, std::size_t i) {
    return column.empty() ? std::numeric_limits<double>::quiet_NaN() : column[i];
  };
  std::string text = "$data << EOD\n# place T strain strain_model residual R R_model\n";
  for (std::size_t i = 0; i < place.size(); ++i) {
    const double measured = at(run.strain_measured, i);
    const double model = at(run.strain_model, i);
    text += fmt::format(
        "{} {} {} {} {} {} {}\n", report::plotted(place[i]),
        report::plotted(at(run.temperature_K, i) - zero_degC_K),
        report::plotted(heat ? measured : 100 * measured),
        report::plotted(heat ? model : 100 * model),
        report::plotted(heat ? model - measured : 100 * (model - measured) / nominal_stroke),
        report::plotted(at(run.resistance_measured, i)),
        report::plotted(at(run.resistance_model, i)));
  }
  return text + "EOD\n";
}

class RunDrawing {
 public:
  RunDrawing(const FittedRun& fitted, const Run& run, double nominal_stroke)
      : run_(fitted),
        name_(file_name(fitted.name)),
        data_(data_block(fitted, places(run), nominal_stroke)) {}

  std::vector<report::Plot> all() const {
    std::vector<report::Plot> plots;
    const bool strain = run_.strain.count > 0;
    const bool resistance = run_.resistance.count > 0;
    switch (run_.kind) {
      case RunKind::calorimetry:
        return {curve("heat flow", "temperature", "heat flow in W/kg", 2, 3, 4, true),
                residual("temperature", 2, "model - measured in W/kg")};
      case RunKind::bath:
        if (strain) {
          plots.push_back(curve("strain", "temperature", "strain in %", 2, 3, 4, true));
          plots.push_back(residual("temperature", 2, residual_label));
        }
        if (resistance) {
          plots.push_back(curve("resistance", "temperature", "resistance in Ω", 2, 6, 7, true));
        }
        break;
      case RunKind::joule:
      case RunKind::settled: {
        const char* over = run_.kind == RunKind::joule ? "time" : "number of the state";
        plots.push_back(curve("strain", over, "strain in %", 1, 3, 4, false));
        plots.push_back(curve("resistance", over, "resistance in Ω", 1, 6, 7, false));
        plots.push_back(residual(over, 1, residual_label));
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

  /// The fitted parameters of this run alone, in words.
  std::string circumstances() const {
    const Circumstances<double>& c = run_.circumstances;
    std::string text;
    if (run_.kind == RunKind::joule || run_.kind == RunKind::settled) {
      text = fmt::format("Ambient {:.1f} °C, heat loss times {:.3f}. ", c.ambient_K - zero_degC_K,
                         c.loss);
    }
    if (run_.strain.count > 0) {
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

  report::Plot curve(const char* what, const char* over, const char* label, int x, int measured,
                     int model, bool half) const {
    const std::vector<std::string> curves{
        fmt::format("$data using {}:{} with lines lc rgb reference lw 2.5 title 'measured'", x,
                    measured),
        fmt::format("$data using {}:{} with lines lc rgb estimate title 'model'", x, model)};
    return plot(fmt::format("{}: {} over {}", name_, what, over),
                std::string_view(what) == "strain" ? circumstances() : "", unit(over), label, half,
                "", curves);
  }

  report::Plot residual(const char* over, int x, const char* label) const {
    return plot(fmt::format("{}: what is left", name_), "What the model does not explain.",
                unit(over), label, true, "set xzeroaxis lt 1 lc rgb '#666666'\n",
                {fmt::format("$data using {}:5 with lines lc rgb estimate notitle", x)});
  }

  report::Plot loop() const {
    return plot(fmt::format("{}: strain over resistance", name_),
                "The relation that an observer uses.", "resistance in Ω", "strain in %", true, "",
                {"$data using 6:3 with lines lc rgb reference lw 2.5 title 'measured'",
                 "$data using 7:4 with lines lc rgb estimate title 'model'"});
  }

  report::Plot plot(std::string title, std::string caption, const std::string& x_label,
                    const char* y_label, bool half, const std::string& more,
                    const std::vector<std::string>& curves) const {
    const report::Axes axes =
        half ? report::Axes{500, 400, x_label, y_label} : report::Axes{1000, 320, x_label, y_label};
    return {std::move(title), std::move(caption), half, report::draw(axes, data_, more, curves)};
  }

  const FittedRun& run_;
  std::string name_;
  std::string data_;
};

}  // namespace

std::vector<report::Plot> draw_fit(const FitResult& fit, const std::vector<Run>& runs) {
  std::vector<report::Plot> all;
  for (std::size_t i = 0; i < fit.runs.size(); ++i) {
    const RunDrawing drawing(fit.runs[i], runs[i], fit.wire.nominal_stroke);
    for (report::Plot& plot : drawing.all()) {
      all.push_back(std::move(plot));
    }
  }
  return all;
}

}  // namespace smaservo::identify
