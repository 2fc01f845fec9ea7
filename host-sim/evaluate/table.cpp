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

namespace smaservo {
namespace {

constexpr double no_scale = std::numeric_limits<double>::quiet_NaN();

using Figures = std::vector<Figure>;

struct Cell {
  std::string text;
  bool missed = false;
};
using Cells = std::vector<std::vector<Cell>>;  ///< the first line is the head

std::string number(double value, int digits = 2) {
  return std::isnan(value)   ? ""
         : std::isinf(value) ? "never"
                             : fmt::format("{:.{}f}", value, digits);
}

/// Counts are whole.
std::string number(const Figure& figure) {
  const bool count = figure.name == "lost" || figure.name == "locked" || figure.name == "unsure";
  return number(figure.value, count ? 0 : 2);
}

std::string target(const Figure& figure) {
  if (!figure.has_target()) {
    return "";
  }
  return std::isnan(figure.least) ? fmt::format("{:.3g}", figure.most)
                                  : fmt::format("{:g} to {:g}", figure.least, figure.most);
}

std::string three(const RowFigures& f) {
  return f.runs == 0 ? ""
                     : fmt::format("{:.2f} / {:.2f} / {:.1f}", f.error.mean(),
                                   f.error.quantile(0.95), f.error.maximum());
}

void add_families(std::vector<Cell>& line) {
  for (const Family family : families) {
    line.push_back({std::string(family_name(family))});
  }
}

Cells errors(const ObserverEvaluation& observer) {
  Cells grid{{{"row"}, {"runs"}, {"mean"}, {"95 %"}, {"max"}, {"lost"}, {"in 2 sd"}, {"target"}}};
  add_families(grid.front());
  for (const RowResult& result : observer.rows) {
    const Figures f = row_figures(observer, result);
    const auto figure = [&](std::size_t i) { return Cell{number(f[i]), f[i].missed()}; };
    std::string targets = target(f[0]);
    for (const std::size_t i : {1U, 2U}) {
      targets += f[i].has_target() ? " / " + target(f[i]) : "";
    }
    std::vector<Cell> line{
        {std::string(row_of(result).name)},
        {fmt::format("{}", result.all.runs)},
        figure(0),
        figure(1),
        figure(2),
        figure(3),
        {std::isnan(f[4].value) ? "" : fmt::format("{:.1f}", f[4].value), f[4].missed()},
        {targets}};
    for (const RowFigures& family : result.by_family) {
      line.push_back({three(family)});
    }
    grid.push_back(std::move(line));
  }
  return grid;
}

std::string meaning(std::string_view figure) {
  struct Named {
    std::string_view name, meaning;
  };
  constexpr Named all[] = {{"drift_mean_percent", "drift in % of the stroke, mean"},
                           {"drift_p95_percent", "drift, 95 %"},
                           {"drift_max_percent", "drift, greatest"},
                           {"found_median_s", "seconds of motion until within 6 %, median"},
                           {"found_p90_s", "seconds of motion until within 6 %, 90 %"},
                           {"locked", "runs never found"},
                           {"unsure", "runs unsure after one heating"}};
  return std::string(std::ranges::find(all, figure, &Named::name)->meaning);
}

/// What only some rows have; the head alone where none of these rows is there.
Cells particulars(const ObserverEvaluation& observer) {
  Cells grid{{{"row"}, {""}, {"value"}, {"target"}}};
  add_families(grid.front());
  for (const RowResult& result : observer.rows) {
    const Figures all = row_figures(observer, result);
    for (std::size_t i = 5; i < all.size(); ++i) {
      std::vector<Cell> line{{std::string(row_of(result).name)},
                             {meaning(all[i].name)},
                             {number(all[i]), all[i].missed()},
                             {target(all[i])}};
      for (const RowFigures& family : result.by_family) {
        line.push_back({number(row_figures(row_of(result), family, no_scale)[i])});
      }
      grid.push_back(std::move(line));
    }
  }
  return grid;
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
  const EvaluatedRun& run = judged->run;
  return fmt::format("{}: mean {:.2f}, {} {}, {}{}, seed {}", row_of(row).name,
                     judged->figures.error.mean(), family_name(run.family), run.unit,
                     condition_name(run.condition), run.disturbed ? " disturbed" : "", run.seed);
}

/// Columns of the width that they need; a number that misses its target has a star.
std::string as_text(const Cells& grid) {
  std::vector<std::size_t> widths(grid.front().size());
  for (const auto& line : grid) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      widths[i] = std::max(widths[i], line[i].text.size());
    }
  }
  std::string text;
  for (const auto& line : grid) {
    std::string row;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const bool left = i == 0 || grid.front()[i].text.empty();
      row += left ? fmt::format("{:<{}}", line[i].text, widths[i])
                  : fmt::format("  {:>{}}{}", line[i].text, widths[i], line[i].missed ? '*' : ' ');
      row += left && i == 0 ? "  " : "";
    }
    text += row.substr(0, row.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

std::string as_markdown(const Cells& grid) {
  std::string text;
  for (std::size_t row = 0; row < grid.size(); ++row) {
    text += "|";
    for (const Cell& cell : grid[row]) {
      text += cell.missed ? fmt::format(" **{}** |", cell.text) : fmt::format(" {} |", cell.text);
    }
    text += "\n";
    if (row == 0) {
      for (std::size_t i = 0; i < grid[0].size(); ++i) {
        text += i == 0 || grid[0][i].text.empty() ? "|---" : "|--:";
      }
      text += "|\n";
    }
  }
  return text;
}

std::string as_html(const Cells& grid) {
  std::string html = "<table>\n";
  for (std::size_t row = 0; row < grid.size(); ++row) {
    html += "<tr>";
    for (const Cell& cell : grid[row]) {
      const char* tag = row == 0 ? "th" : "td";
      html += fmt::format("<{0}{1}>{2}</{0}>", tag, cell.missed ? " class=\"lost\"" : "",
                          escaped(cell.text));
    }
    html += "</tr>\n";
  }
  return html + "</table>\n";
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
      if (!std::isnan(figure.least)) {
        entry["least"] = figure.least;
      }
      entry["most"] = figure.most;
      entry["missed"] = figure.missed();
    }
  }
  return json;
}

nlohmann::ordered_json run_json(const JudgedRun& judged) {
  const EvaluatedRun& run = judged.run;
  const ErrorStatistics& error = judged.figures.error;
  nlohmann::ordered_json json{{"family", family_name(run.family)},
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
  for (const Family family : families) {
    const RowFigures& f = result.by_family[static_cast<std::size_t>(family)];
    json[std::string(family_name(family))] =
        numbers(row_figures(row_of(result), f, no_scale), f.runs);
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
    text += fmt::format("\n{}\n{}", observer.observer, as_text(errors(observer)));
    const Cells particular = particulars(observer);
    text += particular.size() > 1 ? "\n" + as_text(particular) : "";
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
  return json.dump(2) + "\n";
}

std::string table_markdown(const Evaluation& evaluation) {
  std::string text = title(evaluation) + ". Bold: misses its target.\n";
  for (const ObserverEvaluation& observer : evaluation.observers) {
    text += fmt::format("\n`{}`\n\n{}", observer.observer, as_markdown(errors(observer)));
    const Cells particular = particulars(observer);
    text += particular.size() > 1 ? "\n" + as_markdown(particular) : "";
  }
  return text;
}

void write_table_report(const std::string& path, const Evaluation& evaluation) {
  std::string html = fmt::format("<p>{}.</p>\n", escaped(title(evaluation)));
  for (const ObserverEvaluation& observer : evaluation.observers) {
    html += fmt::format("<h2>{}</h2>\n{}", escaped(observer.observer), as_html(errors(observer)));
    const Cells particular = particulars(observer);
    html += particular.size() > 1 ? as_html(particular) : "";
    html += "<p class=\"caption\">Worst runs:</p><ul class=\"caption\">\n";
    for (const RowResult& row : observer.rows) {
      html += fmt::format("<li>{}</li>\n", worst(row));
    }
    html += "</ul>\n";
  }
  html += "<h2>Rows</h2>\n<ul>\n";
  for (const EvaluationRow& row : evaluation_rows()) {
    html += fmt::format("<li>{}: {}</li>\n", row.name, escaped(row.meaning));
  }
  write_html(path, "Evaluation of observers", html + "</ul>\n");
}

TableFile::TableFile(std::string path) : path_(std::move(path)) {
  constexpr std::string_view begin = "<!-- evaluate:";
  constexpr std::string_view end = "<!-- end of evaluate -->";
  const std::ifstream input(path_, std::ios::binary);
  std::stringstream content;
  content << input.rdbuf();
  if (!input) {
    throw UserError(fmt::format("--markdown {}: can not be read", path_));
  }
  const std::string text = content.str();
  const std::size_t head = text.find(begin);
  const std::size_t from = text.find('\n', head);
  const std::size_t to = text.find(end, head);
  if (head == std::string::npos || from == std::string::npos || to == std::string::npos) {
    throw UserError(
        fmt::format("--markdown {}: needs a line that begins with \"{}\", and \"{}\" "
                    "after it",
                    path_, begin, end));
  }
  before_ = text.substr(0, from + 1);
  after_ = text.substr(to);
}

void TableFile::rewrite(const std::string& markdown) const {
  OutputFile file(path_);
  file.write(before_ + "\n" + markdown + "\n" + after_);
  file.commit();
}

}  // namespace smaservo
