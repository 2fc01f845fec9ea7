#include "host-sim/campaign/report.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "host-sim/report/html.hpp"
#include "model/files/error.hpp"

namespace smaservo::campaign {
namespace {

constexpr std::size_t most_worst = 10;
constexpr double certain_deviations = 3;
/// Of fewer trials the quantiles of 5 and 95 % are the least and the greatest value.
constexpr std::size_t fewest_for_quantiles = 20;

/// Cuts a line of a chunk into its cells.
std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') {
      const bool doubled = quoted && i + 1 < line.size() && line[i + 1] == '"';
      if (doubled) {
        cells.back() += c;
        ++i;
      } else {
        quoted = !quoted;
      }
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

double number_in(const std::string& cell) {
  double number = std::numeric_limits<double>::quiet_NaN();
  std::from_chars(cell.data(), cell.data() + cell.size(), number);
  return number;
}

bool is_worse(const WorstTrial& a, const WorstTrial& b) {
  return a.value > b.value || (a.value == b.value && a.trial < b.trial);
}

/// The columns of the trials that statistics are made of.
class Gathered {
 public:
  /// A table gets all trials.
  Gathered(const Campaign& campaign, std::uint64_t every, Table* table)
      : columns_(campaign.trials->columns()),
        every_(every),
        table_(table),
        numbers_(columns_.size()),
        texts_(columns_.size()) {
    const auto found = std::ranges::find(columns_, campaign.trials->main_column(), &Column::name);
    main_ = static_cast<std::size_t>(found - columns_.begin());
  }

  void add(std::uint64_t trial, std::string_view line) {
    std::vector<std::string> cells = cells_of(line);
    if (cells.size() != columns_.size() + 1) {
      throw files::UserError(
          fmt::format("trial {}: has {} cells, not {}", trial, cells.size(), columns_.size() + 1));
    }
    rank(trial, number_in(cells[main_ + 1]));
    if (trial % every_ == 0) {
      count(cells);
    }
    if (table_ != nullptr) {
      cells.erase(cells.begin());
      table_->add(cells);
    }
  }

  const std::vector<Column>& columns() const { return columns_; }
  const std::vector<double>& main() const { return numbers_[main_]; }
  const std::vector<double>& numbers(std::size_t column) const { return numbers_[column]; }
  const std::vector<WorstTrial>& worst() const { return worst_; }

  /// The main column by the classes of a text column.
  std::map<std::string, std::vector<double>> by_class(std::size_t column) const {
    std::map<std::string, std::vector<double>> classes;
    for (std::size_t i = 0; i < main().size(); ++i) {
      classes[names_[texts_[column][i]]].push_back(main()[i]);
    }
    return classes;
  }

 private:
  /// Takes a trial, whose number is its first cell, into the statistics.
  void count(const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i].text) {
        texts_[i].push_back(code(cells[i + 1]));
      } else {
        numbers_[i].push_back(number_in(cells[i + 1]));
      }
    }
  }
  void rank(std::uint64_t trial, double value) {
    const WorstTrial one{trial, value};
    if (std::isnan(value)) {
      return;
    }
    worst_.insert(std::ranges::upper_bound(worst_, one, is_worse), one);
    if (worst_.size() > most_worst) {
      worst_.pop_back();
    }
  }
  std::uint32_t code(const std::string& text) {
    const auto [found, is_new] = codes_.emplace(text, static_cast<std::uint32_t>(names_.size()));
    if (is_new) {
      names_.push_back(text);
    }
    return found->second;
  }

  const std::vector<Column>& columns_;
  std::uint64_t every_;
  Table* table_;
  std::size_t main_ = 0;
  std::vector<std::vector<double>> numbers_;
  std::vector<std::vector<std::uint32_t>> texts_;
  std::map<std::string, std::uint32_t> codes_;
  std::vector<std::string> names_;
  std::vector<WorstTrial> worst_;
};

void gather_chunk(Gathered& all, std::uint64_t first, std::string_view rows) {
  for (std::uint64_t trial = first; !rows.empty(); ++trial) {
    const std::size_t end = rows.find('\n');
    all.add(trial, rows.substr(0, end));
    rows.remove_prefix(end + 1);
  }
}

std::vector<double> sorted_numbers(const std::vector<double>& numbers) {
  std::vector<double> sorted;
  std::ranges::copy_if(numbers, std::back_inserter(sorted),
                       [](double x) { return !std::isnan(x); });
  std::ranges::sort(sorted);
  return sorted;
}

files::TextTable quantile_table(const Gathered& all) {
  files::TextTable table({{"result"},
                          {"trials", "{}"},
                          {"least", "{:.4g}"},
                          {"5 %", "{:.4g}"},
                          {"median", "{:.4g}"},
                          {"95 %", "{:.4g}"},
                          {"greatest", "{:.4g}"}});
  for (std::size_t i = 0; i < all.columns().size(); ++i) {
    const Column& column = all.columns()[i];
    const std::vector<double> sorted = sorted_numbers(all.numbers(i));
    if (column.drawn || column.text || column.quiet || sorted.empty()) {
      continue;
    }
    files::TextTable::Row row{column.name, sorted.size()};
    for (const double share : {0.0, 0.05, 0.5, 0.95, 1.0}) {
      const bool outer = share == 0.05 || share == 0.95;
      if (outer && sorted.size() < fewest_for_quantiles) {
        row.emplace_back("");
        continue;
      }
      const double at = share * static_cast<double>(sorted.size() - 1);
      row.emplace_back(sorted[static_cast<std::size_t>(std::lround(at))]);
    }
    table.add(std::move(row));
  }
  return table;
}

files::TextTable class_table(const Gathered& all, const std::string& main) {
  files::TextTable table(
      {{"class"}, {"trials", "{}"}, {"mean of " + main, "{:.4g}"}, {"greatest", "{:.4g}"}});
  for (std::size_t i = 0; i < all.columns().size(); ++i) {
    if (!all.columns()[i].text || all.columns()[i].quiet) {
      continue;
    }
    for (const auto& [name, values] : all.by_class(i)) {
      if (name.empty()) {
        continue;  // these trials have none
      }
      files::TextTable::Row row{all.columns()[i].name + ": " + name, values.size()};
      const std::vector<double> sorted = sorted_numbers(values);
      if (!sorted.empty()) {
        row.emplace_back(std::accumulate(sorted.begin(), sorted.end(), 0.0) /
                         static_cast<double>(sorted.size()));
        row.emplace_back(sorted.back());
      }
      table.add(std::move(row));
    }
  }
  return table;
}

/// Ranks from 0; equal numbers have the mean of theirs.
std::vector<double> ranks_of(const std::vector<double>& numbers) {
  std::vector<std::size_t> order(numbers.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t i) { return numbers[i]; });
  std::vector<double> ranks(numbers.size());
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin;
    while (end < order.size() && numbers[order[end]] == numbers[order[begin]]) {
      ++end;
    }
    for (std::size_t i = begin; i < end; ++i) {
      ranks[order[i]] = 0.5 * static_cast<double>(begin + end - 1);
    }
    begin = end;
  }
  return ranks;
}

std::vector<Sensitivity> sensitivities_of(const Gathered& all) {
  std::vector<Sensitivity> found;
  const auto count = static_cast<double>(sorted_numbers(all.main()).size());
  for (std::size_t i = 0; i < all.columns().size(); ++i) {
    const Column& column = all.columns()[i];
    // A seed is a name, not a quantity.
    if (!column.drawn || column.text || column.name == "seed") {
      continue;
    }
    const double correlation = rank_correlation(all.numbers(i), all.main());
    found.push_back({column.name, correlation,
                     std::abs(correlation) * std::sqrt(count - 1) > certain_deviations});
  }
  const auto strength = [](const Sensitivity& s) {
    return std::isnan(s.correlation) ? -1 : std::abs(s.correlation);
  };
  std::ranges::sort(found, [&](const Sensitivity& a, const Sensitivity& b) {
    return std::pair(-strength(a), a.column) < std::pair(-strength(b), b.column);
  });
  return found;
}

files::TextTable sensitivity_table(const Report& report) {
  files::TextTable table({{"drawn"}, {"rank correlation with " + report.main, "{:.3f}"}});
  for (const Sensitivity& s : report.sensitivities) {
    table.add({s.column, {s.correlation, s.certain}});
  }
  return table;
}

std::string statistics_title(const Campaign& campaign, const Report& report) {
  return fmt::format("{}: {} trial{} of the kind {}{}", campaign.plan.path, report.trials,
                     report.trials == 1 ? "" : "s", campaign.plan.kind,
                     report.used < report.trials
                         ? fmt::format("; statistics of {} of them, the worst of all", report.used)
                         : "");
}

/// The kind's own table; empty if it says nothing more.
std::string own_text(const Report& report) {
  return report.table ? report.table->text() : "";
}

constexpr const char* certain_note = "more than three standard deviations from what chance gives.";

/// How many trials have how much of the main column.
report::Panel histogram(const Report& report) {
  constexpr int bins = 50;
  const double low = report.sorted.front();
  const double width = (report.sorted.back() - low) / bins;
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i < bins; ++i) {
    const double from = low + i * width;
    const auto begin = std::ranges::lower_bound(report.sorted, from);
    const auto end =
        i + 1 < bins ? std::ranges::lower_bound(report.sorted, from + width) : report.sorted.end();
    x.push_back(from);
    y.push_back(static_cast<double>(end - begin));
  }
  x.push_back(report.sorted.back());
  y.push_back(0);
  report::Panel panel;
  panel.title = "Distribution";
  panel.x.label = report.main;
  panel.y.label = "trials";
  panel.y.min = 0;
  panel.series.push_back({.name = "",
                          .colour = "estimate",
                          .kind = report::Kind::steps,
                          .x = report::column(std::move(x)),
                          .y = report::column(std::move(y))});
  return panel;
}

}  // namespace

double rank_correlation(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> both_x;
  std::vector<double> both_y;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isnan(x[i]) && !std::isnan(y[i])) {
      both_x.push_back(x[i]);
      both_y.push_back(y[i]);
    }
  }
  const std::vector<double> a = ranks_of(both_x);
  const std::vector<double> b = ranks_of(both_y);
  const double mean = 0.5 * (static_cast<double>(a.size()) - 1);
  double ab = 0;
  double aa = 0;
  double bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - mean) * (b[i] - mean);
    aa += (a[i] - mean) * (a[i] - mean);
    bb += (b[i] - mean) * (b[i] - mean);
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : std::numeric_limits<double>::quiet_NaN();
}

Report make_report(const Campaign& campaign, const Folder& folder, bool with_table,
                   std::uint64_t most_used) {
  const Plan& plan = campaign.plan;
  std::unique_ptr<Table> table =
      with_table || plan.trials <= most_used ? campaign.trials->table() : nullptr;
  Gathered all(campaign, (plan.trials + most_used - 1) / most_used, table.get());
  for (std::uint64_t i = 0; i < plan.chunks(); ++i) {
    const ChunkFile file = folder.chunk(campaign, i);
    if (file.state != ChunkState::whole) {
      throw files::UserError(fmt::format("{}: {}", folder.chunk_path(i), file.problem));
    }
    gather_chunk(all, plan.first(i), file.rows());
    if (table) {
      std::ranges::for_each(file.files(), [&](const TrialFile& one) { table->add(one); });
    }
  }
  const std::string main(campaign.trials->main_column());
  std::vector<double> sorted = sorted_numbers(all.main());
  std::erase_if(sorted, [](double x) { return std::isinf(x); });
  return {main,
          plan.trials,
          all.main().size(),
          all.worst(),
          sensitivities_of(all),
          quantile_table(all),
          class_table(all, main),
          std::move(sorted),
          std::move(table)};
}

std::string report_text(const Campaign& campaign, const Report& report) {
  std::string text = statistics_title(campaign, report) + "\n\n";
  if (const std::string own = own_text(report); !own.empty()) {
    text += own + '\n';
  }
  text += report.quantiles.text();
  if (!report.sensitivities.empty()) {
    text += "\n" + sensitivity_table(report).text() + "A star: " + certain_note + "\n";
  }
  text += report.classes.empty() ? "" : "\n" + report.classes.text();
  text += fmt::format("\nGreatest {}:\n", report.main);
  for (const WorstTrial& one : report.worst) {
    text += fmt::format("{:.4g}, trial {}:\n  {}\n", one.value, one.trial,
                        campaign.trials->command(one.trial));
  }
  return text;
}

void write_report(const std::string& path, const Campaign& campaign, const Report& report) {
  std::string html =
      fmt::format("<p>{}.</p>\n", files::escaped(statistics_title(campaign, report)));
  if (const std::string own = own_text(report); !own.empty()) {
    html += fmt::format("<pre>{}</pre>\n", files::escaped(own));
  }
  if (!report.sorted.empty()) {
    html += report::plots_html({histogram(report)}, Units::bench);
  }
  html += "<h2>Quantiles</h2>\n" + report.quantiles.html();
  if (!report.sensitivities.empty()) {
    html += fmt::format("<h2>Sensitivity</h2>\n{}<p class=\"caption\">Bold: {}</p>\n",
                        sensitivity_table(report).html(), certain_note);
  }
  html += "<h2>Classes</h2>\n" + report.classes.html();
  html += fmt::format("<h2>Greatest {}</h2>\n<ul>\n", files::escaped(report.main));
  for (const WorstTrial& one : report.worst) {
    html += fmt::format("<li>{:.4g}, trial {}: <code>{}</code></li>\n", one.value, one.trial,
                        files::escaped(campaign.trials->command(one.trial)));
  }
  report::write_html(path, "Campaign", html + "</ul>\n");
}

}  // namespace smaservo::campaign
