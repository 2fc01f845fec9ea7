#include "host-sim/evaluate/runs_file.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <limits>
#include <span>
#include <utility>

#include "model/files/error.hpp"
#include "model/files/toml/toml_fields.hpp"

namespace smaservo::evaluate {
namespace {

constexpr std::string_view runs_head =
    "observer,row,family,unit,condition,disturbed,seed,error_sum_percent,error_max_percent,lost,"
    "with_sd,within_2_sd,drift_percent,found_s,locked,sure,errors";
constexpr std::size_t cells = 17;
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

std::string number(double value) {
  return std::isnan(value) ? "" : fmt::to_string(value);
}

std::string counts(const replay::ErrorStatistics& errors) {
  std::string text;
  for (std::size_t i = 0; i < errors.bins().size(); ++i) {
    if (errors.bins()[i] > 0) {
      text += fmt::format("{}{}:{}", text.empty() ? "" : " ", i, errors.bins()[i]);
    }
  }
  return text;
}

std::string line_of(const std::string& observer, const EvaluationRow& row,
                    const JudgedRun& judged) {
  const EvaluatedRun& run = judged.run;
  const RunFigures& f = judged.figures;
  const bool start = judged.start.has_value();
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", observer, row.name,
                     hal::family_name(run.family), run.unit, condition_name(run.condition),
                     run.disturbed, run.seed, f.error.sum(), f.error.maximum(), f.lost, f.with_sd,
                     f.within_2_sd, number(judged.drift_percent),
                     start ? number(judged.start->found_after_s) : "",
                     start ? fmt::to_string(judged.start->locked) : "",
                     start ? fmt::to_string(judged.start->sure) : "", counts(f.error));
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t end = 0; end != std::string_view::npos;) {
    end = text.find(separator);
    parts.push_back(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? 0 : end + 1);
  }
  return parts;
}

/// The cells of a line, taken in their order.
class Line {
 public:
  Line(std::size_t line, std::string_view text) : line_(line), cells_(split(text, ',')) {
    if (cells_.size() != cells) {
      fail(fmt::format("has {} cells, not {}", cells_.size(), cells));
    }
  }

  std::string_view text() { return cells_[next_++]; }
  std::uint64_t whole() { return read<std::uint64_t>(text()); }
  double real() {
    const std::string_view cell = text();
    return cell.empty() ? nothing : read<double>(cell);
  }
  bool flag() {
    const std::string_view cell = text();
    if (cell != "true" && cell != "false" && !cell.empty()) {
      fail_at(cell);
    }
    return cell == "true";
  }
  /// The index of a name among others.
  template <class All, class Name>
  std::size_t index(const All& all, const Name& name) {
    const std::string_view cell = text();
    const auto found = std::ranges::find(all, cell, name);
    if (found == std::ranges::end(all)) {
      fail_at(cell);
    }
    return static_cast<std::size_t>(found - std::ranges::begin(all));
  }
  std::vector<std::uint64_t> bins() {
    constexpr std::uint64_t most = 1'000'000;
    std::vector<std::uint64_t> all;
    const std::string_view cell = text();
    if (cell.empty()) {
      return all;
    }
    for (const std::string_view part : split(cell, ' ')) {
      const std::size_t middle = std::min(part.find(':'), part.size());
      const auto bin = read<std::uint64_t>(part.substr(0, middle));
      if (middle == part.size() || bin < all.size() || bin >= most) {
        fail_at(part);
      }
      all.resize(static_cast<std::size_t>(bin) + 1);
      all.back() = read<std::uint64_t>(part.substr(middle + 1));
    }
    return all;
  }

 private:
  template <class Number>
  Number read(std::string_view cell) {
    Number value{};
    const auto result = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (result.ec != std::errc{} || result.ptr != cell.data() + cell.size()) {
      fail_at(cell);
    }
    return value;
  }
  [[noreturn]] void fail_at(std::string_view cell) const {
    fail(fmt::format("has {} in cell {}", files::quoted(std::string(cell)), next_));
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw files::UserError(fmt::format("judged runs: line {} {}", line_, what));
  }

  std::size_t line_;
  std::vector<std::string_view> cells_;
  std::size_t next_ = 0;
};

KeptRun run_of(Line line) {
  KeptRun kept{};
  kept.observer = line.text();
  kept.row = line.index(evaluation_rows(), &EvaluationRow::name);
  EvaluatedRun& run = kept.judged.run;
  run.family = hal::families[line.index(hal::families, hal::family_name)];
  run.unit = line.whole();
  run.condition = all_conditions[line.index(all_conditions, condition_name)];
  run.disturbed = line.flag();
  run.seed = line.whole();
  const double sum = line.real();
  const double maximum = line.real();
  RunFigures& f = kept.judged.figures;
  f.lost = line.flag();
  f.with_sd = line.whole();
  f.within_2_sd = line.whole();
  kept.judged.drift_percent = line.real();
  StartFigures start{line.real(), false, false};
  start.locked = line.flag();
  start.sure = line.flag();
  if (run.condition == Condition::unknown_start) {
    kept.judged.start = start;
  }
  f.error = replay::ErrorStatistics(line.bins(), sum, maximum);
  return kept;
}

}  // namespace

std::string runs_csv(const Evaluation& evaluation) {
  std::string text = std::string(runs_head) + '\n';
  for (const ObserverEvaluation& observer : evaluation.observers) {
    for (const RowResult& result : observer.rows) {
      for (const JudgedRun& run : result.runs) {
        text += line_of(observer.observer, evaluation_rows().at(result.row), run);
      }
    }
  }
  return text;
}

std::vector<KeptRun> read_runs_csv(std::string_view text) {
  std::vector<KeptRun> runs;
  std::size_t number = 0;
  for (const std::string_view line : split(text, '\n')) {
    ++number;
    if (number == 1 && line != runs_head) {
      throw files::UserError(fmt::format("judged runs: the first line is not \"{}\"", runs_head));
    }
    if (number > 1 && !line.empty()) {
      runs.push_back(run_of(Line(number, line)));
    }
  }
  return runs;
}

void JoinedRuns::add(const KeptRun& run) {
  auto observer = std::ranges::find(observers_, run.observer, &Observer::name);
  if (observer == observers_.end()) {
    observer = observers_.insert(observer, {run.observer, {}});
  }
  auto row = std::ranges::find(observer->rows, run.row, &Row::row);
  if (row == observer->rows.end()) {
    row = observer->rows.insert(row, {run.row, RowSum(families_, run.row), run.judged});
  }
  row->sum.add(run.judged);
  if (run.judged.figures.error.mean() > row->worst.figures.error.mean()) {
    row->worst = run.judged;
  }
}

Evaluation JoinedRuns::evaluation(int units, std::uint64_t seed) const {
  Evaluation evaluation{
      files::load_wire(std::string(files::default_wire)).wire.nominal_stroke, units, seed, {}};
  for (const Observer& observer : observers_) {
    evaluation.observers.push_back({observer.name, {}});
    for (const Row& row : observer.rows) {
      evaluation.observers.back().rows.push_back(row.sum.result({row.worst}));
    }
  }
  return evaluation;
}

}  // namespace smaservo::evaluate
