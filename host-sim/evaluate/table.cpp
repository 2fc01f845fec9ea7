#include "host-sim/evaluate/table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host-sim/evaluate/figures.hpp"
#include "host-sim/report/html.hpp"
#include "model/files/error.hpp"
#include "model/files/output_file.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::evaluate {
namespace {

using Figures = std::vector<Figure>;

/// The text of a figure; counts have no decimals.
std::string number(const Figure& figure) {
  const bool count = figure.name == "locked" || figure.name == "unsure";
  return std::isnan(figure.value)   ? ""
         : std::isinf(figure.value) ? "never"
                                    : fmt::format("{:.{}f}", figure.value, count ? 0 : 2);
}

std::string target(const Figure& figure) {
  if (!figure.has_target()) {
    return "";
  }
  return std::isnan(figure.min) ? fmt::format("{:.3g}", figure.max)
                                : fmt::format("{:g} to {:g}", figure.min, figure.max);
}

/// Those whose figures stand beside each other: all runs, then the runs of each family; the family
/// alone if there is only one.
std::vector<std::optional<hal::Family>> shown(const RowResult& result) {
  std::vector<std::optional<hal::Family>> families;
  if (result.by_family.size() != 1) {
    families.emplace_back();
  }
  for (const FamilyFigures& own : result.by_family) {
    families.emplace_back(own.family);
  }
  return families;
}

std::string_view name_of(std::optional<hal::Family> family) {
  return family ? hal::family_name(*family) : "all";
}

/// Mean, 95 % and greatest error: "0.4/1.2/4". A target after the last one is left out, one before
/// it is a dash.
std::string targets_of_error(const Figures& f) {
  std::string text;
  std::string before;
  for (std::size_t i = 0; i < 3; ++i) {
    if (f[i].has_target()) {
      text += before + target(f[i]);
      before = "/";
    } else if (text.empty()) {
      before += "–/";
    }
  }
  return text;
}

/// Marked values miss their target.
files::TextTable errors(const ObserverEvaluation& observer) {
  files::TextTable table({{"row"},
                          {"family"},
                          {"runs", "{}"},
                          {"mean", "{:.2f}"},
                          {"95 %", "{:.2f}"},
                          {"max", "{:.1f}"},
                          {"lost", "{:.0f}"},
                          {"in 2 sd", "{:.1f}"},
                          {"target", "{}"}},
                         "");
  for (const RowResult& result : observer.rows) {
    for (const std::optional<hal::Family> family : shown(result)) {
      const int runs = runs_of(result, family).runs;
      if (runs == 0) {
        continue;
      }
      const Figures f = row_figures(observer, result, family);
      files::TextTable::Row line{row_of(result).name, name_of(family), runs};
      for (std::size_t i = 0; i < 5; ++i) {
        line.emplace_back(f[i].value, f[i].missed());
      }
      line.emplace_back(targets_of_error(f));
      table.add(std::move(line));
    }
  }
  return table;
}

std::string meaning(std::string_view figure) {
  struct Named {
    std::string_view name, meaning;
  };
  constexpr Named all[] = {{"drift_mean_percent", "drift: mean, %"},
                           {"drift_p95_percent", "drift: 95 %, %"},
                           {"drift_max_percent", "drift: greatest, %"},
                           {"found_median_s", "motion until found: median, s"},
                           {"found_p90_s", "motion until found: 90 %, s"},
                           {"locked", "never found"},
                           {"unsure", "unsure after one heating"}};
  return std::string(std::ranges::find(all, figure, &Named::name)->meaning);
}

/// The figures that only some rows have. Marked values miss their target.
files::TextTable particulars(const ObserverEvaluation& observer) {
  std::vector<files::TextTable::Column> columns{{"row"}, {""}, {"target", "{}"}};
  for (const std::optional<hal::Family> family : shown(observer.rows.front())) {
    columns.push_back({std::string(name_of(family)), "{}"});
  }
  files::TextTable table(std::move(columns), "");
  for (const RowResult& result : observer.rows) {
    std::vector<Figures> beside;
    for (const std::optional<hal::Family> family : shown(result)) {
      beside.push_back(row_figures(observer, result, family));
    }
    for (std::size_t i = 5; i < beside.front().size(); ++i) {
      const Figure& first = beside.front()[i];
      files::TextTable::Row line{row_of(result).name, meaning(first.name), target(first)};
      for (const Figures& figures : beside) {
        line.emplace_back(number(figures[i]), figures[i].missed());
      }
      table.add(std::move(line));
    }
  }
  return table;
}

std::string title(const Evaluation& e) {
  const std::uint64_t last = e.seed + static_cast<std::uint64_t>(e.units) - 1;
  return fmt::format(
      "Error in % of the nominal stroke ({:g} % strain) after the first second, of units {} of "
      "each "
      "family",
      100 * e.stroke,
      e.units == 1 ? fmt::format("{}", last) : fmt::format("{} to {}", e.seed, last));
}

/// The run with the greatest mean error.
std::string worst(const RowResult& row) {
  const auto judged = std::ranges::max_element(
      row.runs, {}, [](const JudgedRun& run) { return run.figures.error.mean(); });
  return fmt::format("{}: mean {:.2f}, {}", row_of(row).name, judged->figures.error.mean(),
                     run_text(judged->run));
}

nlohmann::ordered_json numbers(const Figures& figures, int runs) {
  nlohmann::ordered_json json{{"runs", runs}};
  for (const Figure& figure : figures) {
    json[std::string(figure.name)] = figure.value;
  }
  return json;
}

nlohmann::ordered_json targets(const Figures& figures) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Figure& figure : figures) {
    if (figure.has_target()) {
      auto& entry = json[std::string(figure.name)];
      if (!std::isnan(figure.min)) {
        entry["min"] = figure.min;
      }
      entry["max"] = figure.max;
      entry["missed"] = figure.missed();
    }
  }
  return json;
}

nlohmann::ordered_json run_json(const JudgedRun& judged) {
  const EvaluatedRun& run = judged.run;
  const replay::ErrorStatistics& error = judged.figures.error;
  nlohmann::ordered_json json{{"family", hal::family_name(run.family)},
                              {"unit", run.unit},
                              {"condition", condition_name(run.condition)},
                              {"disturbed", run.disturbed},
                              {"seed", run.seed},
                              {"mean_percent", error.mean()},
                              {"p95_percent", error.quantile(0.95)},
                              {"max_percent", error.maximum()},
                              {"lost", judged.figures.lost}};
  if (run.condition == Condition::hold_ripple) {
    json["drift_percent"] = judged.drift_percent;
  }
  if (judged.start) {
    json["found_after_s"] = judged.start->found_after_s;
    json["locked"] = judged.start->locked;
    json["sure"] = judged.start->sure;
  }
  return json;
}

nlohmann::ordered_json row_json(const ObserverEvaluation& observer, const RowResult& result) {
  const Figures all = row_figures(observer, result);
  nlohmann::ordered_json json{{"row", row_of(result).name}, {"all", numbers(all, result.all.runs)}};
  for (const auto& [family, figures] : result.by_family) {
    const Figures own = row_figures(observer, result, family);
    auto& entry = json[std::string(hal::family_name(family))] = numbers(own, figures.runs);
    entry["targets"] = targets(own);
  }
  json["targets"] = targets(all);
  for (const JudgedRun& run : result.runs) {
    json["each_run"].push_back(run_json(run));
  }
  return json;
}

}  // namespace

std::string table_text(const Evaluation& evaluation) {
  std::string text = title(evaluation) + "\n* misses its target\n";
  for (const ObserverEvaluation& observer : evaluation.observers) {
    text += fmt::format("\n{}\n{}", observer.observer, errors(observer).text());
    const files::TextTable particular = particulars(observer);
    text += particular.empty() ? "" : "\n" + particular.text();
    text += "\nworst runs\n";
    for (const RowResult& row : observer.rows) {
      text += worst(row) + "\n";
    }
  }
  return text;
}

std::string table_json(const Evaluation& evaluation) {
  nlohmann::ordered_json json{{"nominal_stroke", evaluation.stroke},
                              {"units_of_each_family", evaluation.units},
                              {"seed", evaluation.seed}};
  auto& observers = json["observers"];
  for (const ObserverEvaluation& observer : evaluation.observers) {
    auto& rows = observers[observer.observer];
    for (const RowResult& row : observer.rows) {
      rows.push_back(row_json(observer, row));
    }
  }
  return files::json_text(json);
}

std::string table_markdown(const Evaluation& evaluation) {
  std::string text = title(evaluation) + ". Bold: misses its target.\n";
  for (const ObserverEvaluation& observer : evaluation.observers) {
    text += fmt::format("\n`{}`\n\n{}", observer.observer, errors(observer).markdown());
    const files::TextTable particular = particulars(observer);
    text += particular.empty() ? "" : "\n" + particular.markdown();
  }
  return text;
}

void write_table_report(const std::string& path, const Evaluation& evaluation) {
  std::string html = fmt::format("<p>{}.</p>\n", files::escaped(title(evaluation)));
  for (const ObserverEvaluation& observer : evaluation.observers) {
    html +=
        fmt::format("<h2>{}</h2>\n{}", files::escaped(observer.observer), errors(observer).html());
    const files::TextTable particular = particulars(observer);
    html += particular.empty() ? "" : particular.html();
    html += "<p class=\"caption\">Worst runs:</p><ul class=\"caption\">\n";
    for (const RowResult& row : observer.rows) {
      html += fmt::format("<li>{}</li>\n", worst(row));
    }
    html += "</ul>\n";
  }
  html += "<h2>Rows</h2>\n<ul>\n";
  for (const EvaluationRow& row : evaluation_rows()) {
    html += fmt::format("<li>{}: {}</li>\n", row.name, files::escaped(row.meaning));
  }
  report::write_html(path, "Evaluation of observers", html + "</ul>\n");
}

TableFile::TableFile(std::string path, std::string_view mark)
    : path_(std::move(path)), mark_(mark) {
  (void)surroundings();
}

TableFile::Surroundings TableFile::surroundings() const {
  const std::string begin = fmt::format("<!-- {}:", mark_);
  const std::string end = fmt::format("<!-- end of {} -->", mark_);
  const std::ifstream input(path_, std::ios::binary);
  std::stringstream content;
  content << input.rdbuf();
  if (!input) {
    throw files::UserError(fmt::format("--markdown {}: cannot be read", path_));
  }
  const std::string text = content.str();
  const std::size_t head = text.find(begin);
  const std::size_t from = text.find('\n', head);
  const std::size_t to = text.find(end, head);
  if (head == std::string::npos || from == std::string::npos || to == std::string::npos) {
    throw files::UserError(
        fmt::format("--markdown {}: needs a line that begins with \"{}\", and \"{}\" "
                    "after it",
                    path_, begin, end));
  }
  return {text.substr(0, from + 1), text.substr(to)};
}

void TableFile::rewrite(const std::string& markdown) const {
  const Surroundings around = surroundings();
  files::OutputFile file(path_);
  file.write(around.before + "\n" + markdown + "\n" + around.after);
  file.commit();
}

}  // namespace smaservo::evaluate
