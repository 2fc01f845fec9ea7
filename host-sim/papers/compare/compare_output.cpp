// A comparison as text, JSON and HTML.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host-sim/identify/fitted_wire.hpp"
#include "host-sim/papers/compare/compare.hpp"
#include "host-sim/report/html.hpp"
#include "model/files/text_table.hpp"
#include "model/units.hpp"

namespace smaservo::compare {
namespace {

std::string percent(double value) {
  return fmt::format("{:.2f}", value);
}

/// "mean / 95 % / max", or "-" if there is no error.
std::string figures(const replay::ErrorStatistics& error) {
  return error.count() == 0 ? "-"
                            : fmt::format("{} / {} / {}", percent(error.mean()),
                                          percent(error.quantile(0.95)), percent(error.maximum()));
}

std::string remark(const Compared& one) {
  const char* silent = "no estimate: the tests lack what it needs";
  const bool asked = static_cast<bool>(one.system.strain);
  return asked && one.error.count() == 0 ? silent : one.system.remark;
}

std::string names(const std::vector<identify::Run>& runs) {
  std::string all;
  for (const identify::Run& run : runs) {
    all += (all.empty() ? "" : ", ") + identify::file_name(run.name);
  }
  return all;
}

std::string heading(const Comparison& comparison) {
  std::string text = fmt::format(
      "Identified on {}; tested on {}. Errors of the strain in % of a {:g} % stroke.",
      names(comparison.training), names(comparison.tests), 100 * comparison.nominal_stroke);
  for (const identify::Run& run : comparison.training) {
    if (!identify::zero_known(run.strain)) {
      text += fmt::format(
          " {}: the strain has a zero of its own; its longest wire is taken to be as long as {} at "
          "rest.",
          identify::file_name(run.name), comparison.from);
    }
  }
  for (std::size_t t = 0; t < comparison.tests.size(); ++t) {
    const Beyond& beyond = comparison.beyond[t];
    if (beyond.stress > 0 || beyond.resistance > 0) {
      text += fmt::format(
          " {} goes beyond the training, where estimates are extrapolated: by its stress "
          "in {:.1f} % of the rows, by its resistance in {:.1f} %.",
          identify::file_name(comparison.tests[t].name), 100 * beyond.stress,
          100 * beyond.resistance);
    }
  }
  for (std::size_t t = 0; t < comparison.tests.size(); ++t) {
    if (comparison.free_zero[t]) {
      text += fmt::format(
          " {}: the strain has a zero of its own; each system's median error is "
          "taken off.",
          identify::file_name(comparison.tests[t].name));
    }
  }
  return text;
}

using Json = nlohmann::ordered_json;

/// The errors as JSON; an empty object if there is none.
Json error_json(const replay::ErrorStatistics& error) {
  Json json{{"rows", error.count()}};
  if (error.count() > 0) {
    json["mean_percent"] = error.mean();
    json["p95_percent"] = error.quantile(0.95);
    json["max_percent"] = error.maximum();
  }
  return json;
}

/// HTML has the mean of each test in the last columns.
files::TextTable table_of(const Comparison& comparison, bool with_tests) {
  std::vector<files::TextTable::Column> columns{{"system"},
                                                {"mean", "{:.2f}"},
                                                {"95 %", "{:.2f}"},
                                                {"max", "{:.2f}"},
                                                {"a row", "{:.0f} ns", "", 1e9},
                                                {"parameters", "{}"}};
  for (std::size_t t = 0; with_tests && t < comparison.tests.size(); ++t) {
    columns.push_back({identify::file_name(comparison.tests[t].name) + ", mean", "{:.2f}"});
  }
  files::TextTable table(std::move(columns));
  for (const Compared& one : comparison.systems) {
    files::TextTable::Row row{one.system.name};
    if (one.error.count() > 0) {
      row.insert(row.end(), {one.error.mean(), one.error.quantile(0.95), one.error.maximum(),
                             one.step_s, one.system.parameters});
      for (std::size_t t = 0; with_tests && t < one.runs.size(); ++t) {
        const replay::ErrorStatistics& error = one.runs[t].error;
        row.push_back(error.count() > 0 ? error.mean() : files::TextTable::Cell{});
      }
    }
    table.add(std::move(row));
  }
  return table;
}

std::string remarks_html(const Comparison& comparison) {
  std::string html = "<p class=\"caption\">";
  for (const Compared& one : comparison.systems) {
    const std::string said = remark(one);
    html +=
        fmt::format("<b>{}</b>: {}{}{}.<br>\n", files::escaped(one.system.name),
                    files::escaped(one.system.meaning),
                    one.system.meaning.empty() || said.empty() ? "" : "; ", files::escaped(said));
  }
  return html + "</p>\n";
}

report::Column percent_of(const std::vector<double>& strain, double stroke = 1) {
  return report::column_of(strain, [&](double e) { return 100 * e / stroke; });
}

/// The panels of one test: the errors of all systems over time, and the estimate of each of them.
class TestPanels {
 public:
  TestPanels(const Comparison& comparison, std::size_t test)
      : comparison_(comparison),
        test_(test),
        run_(comparison.tests[test]),
        link_(fmt::format("test {}", test)),
        bath_(run_.kind == identify::RunKind::bath),
        over_(bath_
                  ? report::column_of(run_.temperature_K, [](double K) { return K - zero_degC_K; })
                  : report::column(run_.resistance_ohm)),
        time_(time()),
        strain_(percent_of(run_.strain)) {}

  std::vector<report::Panel> all() const {
    std::vector<report::Panel> panels;
    for (const Compared& one : comparison_.systems) {
      if (!one.runs.empty() && one.runs[test_].error.count() > 0) {
        if (panels.empty()) {
          panels.push_back(errors());
        }
        add_error(panels.front(), one);
        panels.push_back(loop(one));
      }
    }
    return panels;
  }

 private:
  /// The time of each row; the number of the row if the run has no time.
  report::Column time() const {
    std::vector<double> all = run_.time_s;
    for (std::size_t i = all.size(); i < run_.strain.size(); ++i) {
      all.push_back(static_cast<double>(i));
    }
    return report::column(std::move(all));
  }

  report::Panel errors() const {
    return {.title = fmt::format("{}: errors", identify::file_name(run_.name)),
            .caption = "Estimate less reference, of the nominal stroke.",
            .height = 360,
            .x = {.label = run_.time_s.empty() ? "row" : "time in s"},
            .y = {.label = "error in % of the stroke"},
            .link = link_,
            .rules = {{0, "", "ink"}}};
  }

  void add_error(report::Panel& panel, const Compared& one) const {
    static constexpr const char* colours[] = {"#0059b3", "#d95f02", "#228833", "#aa3377",
                                              "#ddaa33", "#66ccee", "#882255", "#8c8c8c",
                                              "#117733", "#ee6677", "#44aa99", "#4477aa"};
    std::vector<double> error(run_.strain.size());
    for (std::size_t i = 0; i < error.size(); ++i) {
      error[i] = one.runs[test_].strain[i] - run_.strain[i];
    }
    panel.series.push_back({.name = one.system.name,
                            .colour = colours[panel.series.size() % std::size(colours)],
                            .x = time_,
                            .y = percent_of(error, comparison_.nominal_stroke),
                            .dashed = panel.series.size() >= std::size(colours)});
  }

  report::Panel loop(const Compared& one) const {
    return {.title = fmt::format("{}: {}", identify::file_name(run_.name), one.system.name),
            .caption = figures(one.runs[test_].error),
            .half_width = true,
            .height = 360,
            .x = {.label = bath_ ? "temperature in °C" : "resistance in Ω"},
            .y = {.label = "strain in %"},
            .follows = link_,
            .series = {{.name = "reference",
                        .colour = "reference",
                        .x = over_,
                        .y = strain_,
                        .at = time_,
                        .width = 2.5},
                       {.name = "estimate",
                        .colour = "estimate",
                        .x = over_,
                        .y = percent_of(one.runs[test_].strain),
                        .at = time_}}};
  }

  const Comparison& comparison_;
  std::size_t test_;
  const identify::Run& run_;
  std::string link_;
  bool bath_;
  report::Column over_, time_, strain_;
};

}  // namespace

std::string comparison_text(const Comparison& comparison) {
  std::string text = heading(comparison) + "\n\n" + table_of(comparison, false).text();
  for (const Compared& one : comparison.systems) {
    if (const std::string said = remark(one); !said.empty()) {
      text += fmt::format("\n{}: {}.", one.system.name, said);
    }
  }
  return text + "\n";
}

std::string comparison_json(const Comparison& comparison) {
  Json json;
  json["from"] = comparison.from;
  json["nominal_stroke"] = comparison.nominal_stroke;
  for (const identify::Run& run : comparison.training) {
    json["training"].push_back(run.name);
  }
  for (std::size_t t = 0; t < comparison.tests.size(); ++t) {
    json["tests"].push_back({{"file", comparison.tests[t].name},
                             {"free_zero", static_cast<bool>(comparison.free_zero[t])},
                             {"stress_beyond", comparison.beyond[t].stress},
                             {"resistance_beyond", comparison.beyond[t].resistance}});
  }
  for (const Compared& one : comparison.systems) {
    Json system{{"name", one.system.name},
                {"meaning", one.system.meaning},
                {"remark", remark(one)},
                {"identified", static_cast<bool>(one.system.strain)}};
    if (one.system.strain) {
      system["parameters"] = one.system.parameters;
      system["step_s"] = one.step_s;
      system["error"] = error_json(one.error);
      for (std::size_t t = 0; t < comparison.tests.size(); ++t) {
        Json run = error_json(one.runs[t].error);
        run["file"] = comparison.tests[t].name;
        system["tests"].push_back(run);
      }
    }
    json["systems"].push_back(system);
  }
  return files::json_text(json);
}

void write_comparison_report(const std::string& path, const Comparison& comparison, Units units) {
  std::vector<report::Panel> plots;
  for (std::size_t t = 0; t < comparison.tests.size(); ++t) {
    for (report::Panel& panel : TestPanels(comparison, t).all()) {
      plots.push_back(std::move(panel));
    }
  }
  report::write_html(path, "Systems compared",
                     fmt::format("<p>{}</p>\n", files::escaped(heading(comparison))) +
                         table_of(comparison, true).html() + remarks_html(comparison) +
                         report::plots_html(plots, units));
}

}  // namespace smaservo::compare
