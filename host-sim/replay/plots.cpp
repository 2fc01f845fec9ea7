#include "host-sim/replay/plots.hpp"

#include <cmath>
#include <utility>

namespace smaservo::replay {
namespace {

using report::Column;
using report::Panel;
using report::PlotPoint;
using report::Series;

constexpr const char* in_time = "time";

class Drawing {
 public:
  explicit Drawing(const ReplayResult& result)
      : points_(result.series.points()),
        x_label_(result.timed ? "time in s" : "row"),
        time_(of([&](const PlotPoint& p) { return p.time_s - points_.front().time_s; })),
        strain_(of(&PlotPoint::strain_percent)),
        reference_(of(&PlotPoint::strain_ref_percent)),
        resistance_(of(&PlotPoint::resistance_ohm)),
        resistance_model_(of(&PlotPoint::resistance_model_ohm)),
        temperature_(of(&PlotPoint::temperature_degC)),
        has_reference_(result.has_reference),
        has_temperature_ref_(!result.open_loop) {}

  std::vector<Panel> all() const {
    std::vector<Panel> panels{strain()};
    if (has_reference_) {
      panels.push_back(error());
    }
    for (Panel panel : {resistance(), temperature(), phases(), inputs(), strain_resistance(),
                        strain_temperature()}) {
      panels.push_back(std::move(panel));
    }
    return panels;
  }

 private:
  Column of(double PlotPoint::* value) const {
    return report::column_of(points_, [value](const PlotPoint& p) { return p.*value; });
  }
  template <class Value>
  Column of(Value value) const {
    return report::column_of(points_, value);
  }

  Panel strain() const {
    const auto band = [](const PlotPoint& p) {
      return std::isnan(p.strain_sd_percent) ? 0 : 2 * p.strain_sd_percent;
    };
    Panel panel =
        wide("Strain", "Elongation of the whole wire: long is martensite, short is austenite.",
             "strain in %", 320);
    panel.series.push_back(
        {.name = "two standard deviations",
         .colour = "band",
         .kind = report::Kind::band,
         .x = time_,
         .y = of([&](const PlotPoint& p) { return p.strain_percent + band(p); }),
         .low = of([&](const PlotPoint& p) { return p.strain_percent - band(p); })});
    if (has_reference_) {
      panel.series.push_back(
          {.name = "reference", .colour = "reference", .x = time_, .y = reference_, .width = 2.5});
    }
    panel.series.push_back({.name = "estimate", .colour = "estimate", .x = time_, .y = strain_});
    return panel;
  }

  Panel error() const {
    Panel panel = wide("Error", "Estimate less reference, of the nominal stroke.",
                       "error in % of the stroke", 220);
    panel.series.push_back({.name = "estimate less reference",
                            .colour = "estimate",
                            .x = time_,
                            .y = of(&PlotPoint::error_percent)});
    panel.rules.push_back({.at = 0, .name = "", .colour = "measured"});
    return panel;
  }

  Panel resistance() const {
    Panel panel = wide("Resistance", "The measured one is what corrects the estimate.",
                       "resistance in Ω", 260);
    if (report::shows(resistance_)) {
      panel.series.push_back(
          {.name = "measured", .colour = "measured", .x = time_, .y = resistance_});
    }
    panel.series.push_back({.name = "expected by the model",
                            .colour = "estimate",
                            .x = time_,
                            .y = resistance_model_});
    return panel;
  }

  Panel temperature() const {
    Panel panel =
        wide("Temperature", "Of the wire away from its clamps.", "temperature in °C", 260);
    const Column measured = of(&PlotPoint::temperature_ref_degC);
    if (has_temperature_ref_ && report::shows(measured)) {
      panel.series.push_back(
          {.name = "reference", .colour = "reference", .x = time_, .y = measured});
    }
    panel.series.push_back({.name = "wire", .colour = "estimate", .x = time_, .y = temperature_});
    return panel;
  }

  Panel phases() const {
    Panel panel = wide("Phases", "Fractions of the whole wire, stacked.", "fraction", 260);
    panel.y.min = 0;
    panel.y.max = 1;
    const Column zero = of([](const PlotPoint&) { return 0.0; });
    const Column martensite = of(&PlotPoint::martensite);
    const Column both = of([](const PlotPoint& p) { return p.martensite + p.r_phase; });
    const Column one = of([](const PlotPoint&) { return 1.0; });
    const auto area = [&](const char* name, const char* colour, const Column& low,
                          const Column& high) {
      panel.series.push_back({.name = name,
                              .colour = colour,
                              .kind = report::Kind::area,
                              .x = time_,
                              .y = high,
                              .low = low});
    };
    area("martensite", "martensite", zero, martensite);
    area("R-phase", "r_phase", martensite, both);
    area("austenite", "austenite", both, one);
    return panel;
  }

  Panel inputs() const {
    Panel panel = wide("Inputs", "What drives the wire.", "", 220);
    panel.right = {.label = "stress in MPa", .min = 0};
    panel.series.push_back({.name = "stress",
                            .colour = "reference",
                            .x = time_,
                            .y = of(&PlotPoint::stress_MPa),
                            .right = true});
    const Column current = of(&PlotPoint::current_A);
    if (report::shows(current)) {
      panel.y = {.label = "current in A", .min = 0};
      panel.series.push_back({.name = "current", .colour = "estimate", .x = time_, .y = current});
    }
    return panel;
  }

  Panel strain_resistance() const {
    return loop("Strain over resistance",
                "One resistance, several strains: what a straight line misses.", "resistance in Ω",
                report::shows(resistance_) ? resistance_ : resistance_model_);
  }

  Panel strain_temperature() const {
    return loop("Strain over temperature", "The hysteresis between heating and cooling.",
                "temperature in °C", temperature_);
  }

  Panel loop(const char* title, const char* caption, const char* x_label, const Column& x) const {
    Panel panel{.title = title,
                .caption = caption,
                .half_width = true,
                .height = 400,
                .x = {.label = x_label},
                .y = {.label = "strain in %"},
                .follows = in_time};
    if (has_reference_) {
      panel.series.push_back({.name = "reference",
                              .colour = "reference",
                              .x = x,
                              .y = reference_,
                              .at = time_,
                              .width = 2.5});
    }
    panel.series.push_back(
        {.name = "estimate", .colour = "estimate", .x = x, .y = strain_, .at = time_});
    return panel;
  }

  Panel wide(const char* title, const char* caption, const char* y_label, int height) const {
    return {.title = title,
            .caption = caption,
            .height = height,
            .x = {.label = x_label_},
            .y = {.label = y_label},
            .link = in_time};
  }

  std::vector<PlotPoint> points_;
  const char* x_label_;
  Column time_, strain_, reference_, resistance_, resistance_model_, temperature_;
  bool has_reference_, has_temperature_ref_;
};

}  // namespace

std::vector<report::Panel> panels_of(const ReplayResult& result) {
  return Drawing(result).all();
}

}  // namespace smaservo::replay
