#include "host-sim/evaluate/evaluate.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <utility>

#include "host-sim/campaign/kinds/drawn_units.hpp"
#include "host-sim/campaign/kinds/kinds.hpp"
#include "host-sim/evaluate/figures.hpp"
#include "host-sim/evaluate/runs/calibrate.hpp"
#include "host-sim/evaluate/runs_file.hpp"
#include "host-sim/evaluate/table.hpp"
#include "host-sim/replay/observers.hpp"
#include "host-sim/shell_word.hpp"
#include "model/files/error.hpp"

namespace smaservo::campaign {
namespace {

/// Seconds of one core.
constexpr double calibration_cost_s = 120;
constexpr double run_cost_s = 0.25;

/// What is evaluated of each unit.
struct Judging {
  std::vector<hal::Family> families;
  std::vector<std::string> observers;
  std::vector<std::string> rows;
  int runs;
  std::string wires;  ///< folder of calibrated wires; empty: they are calibrated
};

std::string wire_path(const Judging& judging, hal::Family family, std::uint64_t seed) {
  return (std::filesystem::path(judging.wires) / evaluate::calibrated_name(family, seed)).string();
}

/// All runs of all units, as `evaluate` shows those of a few.
class EvaluationTable final : public Table {
 public:
  EvaluationTable(const std::vector<hal::Family>& families, std::uint64_t seed)
      : families_(families), seed_(seed), runs_(families) {}

  void add(const std::vector<std::string>& /*cells*/) override { ++units_; }
  void add(const TrialFile& file) override {
    if (file.name.ends_with(".csv")) {
      for (const evaluate::KeptRun& run : evaluate::read_runs_csv(file.text)) {
        runs_.add(run);
      }
    }
  }
  std::string text() const override { return evaluate::table_text(whole()); }
  std::string markdown() const override { return evaluate::table_markdown(whole()); }
  std::string_view mark() const override {
    const bool usual = std::ranges::equal(families_, hal::tuning_families);
    return usual ? "evaluate" : "other families";
  }

 private:
  evaluate::Evaluation whole() const {
    const auto count = families_.size();
    return runs_.evaluation(static_cast<int>((units_ + count - 1) / count), seed_);
  }

  std::vector<hal::Family> families_;
  std::uint64_t seed_;
  std::size_t units_ = 0;
  evaluate::JoinedRuns runs_;
};

/// A trial is a unit that is calibrated and then measured in all rows.
class Evaluations final : public Trials {
 public:
  Evaluations(std::uint64_t seed, Judging judging) : seed_(seed), judging_(std::move(judging)) {
    std::vector<Column> results;
    for (const auto& [name, figure] : figures_of(no_runs())) {
      results.push_back({name, false});
    }
    columns_ = with_unit_columns(results);
    main_ = results.front().name;
  }

  const std::vector<Column>& columns() const override { return columns_; }
  std::string_view main_column() const override { return main_; }
  double cost_s() const override {
    double runs = 0;
    bool calibrated = false;
    for (const evaluate::EvaluationRow* row : rows()) {
      runs += judging_.runs > 0 ? judging_.runs : row->runs;
      calibrated =
          calibrated || (row->known == evaluate::Known::calibrated && judging_.wires.empty());
    }
    return (calibrated ? calibration_cost_s : 0) +
           run_cost_s * runs * static_cast<double>(judging_.observers.size());
  }

  TrialResult run(std::uint64_t index, const Stop& stop) const override {
    const hal::Family family = family_of(index);
    const std::uint64_t seed = seed_of(index);
    TrialResult result{unit_cells(bench::random_unit(family, seed), seed)};
    const std::string name = evaluate::calibrated_name(family, seed);
    evaluate::EvaluateOptions options;
    options.families = {family};
    options.units = 1;
    options.runs = judging_.runs;
    options.seed = seed;
    options.observers = judging_.observers;
    options.rows = judging_.rows;
    options.calibrated = [&](const bench::WireUnit& unit) {
      if (!judging_.wires.empty()) {
        return files::load_wire(wire_path(judging_, family, seed)).wire;
      }
      const files::WireDescription found =
          evaluate::calibrate(unit, [&] { return !(stop && stop()); });
      if (stop && stop()) {
        throw Stopped();  // the fit has not ended
      }
      result.files.push_back({name, files::to_toml(found)});
      return found.wire;
    };
    options.progress = [&](std::string_view /*stage*/, std::size_t /*done*/, std::size_t /*of*/) {
      if (stop && stop()) {
        throw Stopped();
      }
    };
    const evaluate::Evaluation evaluation = evaluate::evaluate(options);
    for (const auto& [column, value] : figures_of(evaluation)) {
      result.row.emplace_back(value);
    }
    result.files.push_back({name.substr(0, name.rfind('.')) + ".csv", runs_csv(evaluation)});
    return result;
  }

  std::string command(std::uint64_t index) const override {
    std::string line = fmt::format("host-sim evaluate --family {} --units 1 --seed {}",
                                   hal::family_name(family_of(index)), seed_of(index));
    line += judging_.runs > 0 ? fmt::format(" --runs {}", judging_.runs) : "";
    line += judging_.rows.empty() ? "" : fmt::format(" --row {}", fmt::join(judging_.rows, ","));
    line += judging_.observers == evaluate::EvaluateOptions{}.observers
                ? ""
                : fmt::format(" --observer {}", fmt::join(judging_.observers, ","));
    return line + (judging_.wires.empty() ? "" : " --wires " + shell_word(judging_.wires));
  }

  std::unique_ptr<Table> table() const override {
    return std::make_unique<EvaluationTable>(judging_.families, seed_);
  }

 private:
  hal::Family family_of(std::uint64_t index) const {
    return judging_.families[static_cast<std::size_t>(index % judging_.families.size())];
  }
  std::uint64_t seed_of(std::uint64_t index) const {
    return seed_ + index / judging_.families.size();
  }

  std::vector<const evaluate::EvaluationRow*> rows() const {
    std::vector<const evaluate::EvaluationRow*> chosen;
    for (const evaluate::EvaluationRow& row : evaluate::evaluation_rows()) {
      if (judging_.rows.empty() || std::ranges::count(judging_.rows, row.name) > 0) {
        chosen.push_back(&row);
      }
    }
    return chosen;
  }

  /// An evaluation with the chosen observers and rows.
  evaluate::Evaluation no_runs() const {
    evaluate::Evaluation evaluation{};
    for (const std::string& observer : judging_.observers) {
      evaluation.observers.push_back({observer, {}});
      for (const evaluate::EvaluationRow* row : rows()) {
        const auto index = static_cast<std::size_t>(row - evaluate::evaluation_rows().data());
        evaluation.observers.back().rows.push_back(
            evaluate::RowSum(judging_.families, index).result({}));
      }
    }
    return evaluation;
  }

  /// The figures of the chosen observers, with the names of their columns.
  std::vector<std::pair<std::string, double>> figures_of(
      const evaluate::Evaluation& evaluation) const {
    std::vector<std::pair<std::string, double>> all;
    for (const evaluate::ObserverEvaluation& observer : evaluation.observers) {
      // In a hold the model alone is judged besides.
      if (std::ranges::count(judging_.observers, observer.observer) == 0) {
        continue;
      }
      for (const evaluate::RowResult& row : observer.rows) {
        for (const evaluate::Figure& figure : evaluate::row_figures(observer, row)) {
          std::string name =
              fmt::format("{}{}_{}", judging_.observers.size() > 1 ? observer.observer + '_' : "",
                          evaluate::row_of(row).name, figure.name);
          std::ranges::replace(name, '-', '_');
          if (const std::size_t at = name.find("within_2_sd"); at != std::string::npos) {
            name.replace(at, 6, "in");
          }
          all.emplace_back(std::move(name), figure.value);
        }
      }
    }
    return all;
  }

  std::uint64_t seed_;
  Judging judging_;
  std::vector<Column> columns_;
  std::string main_;
};

/// The texts of a list, each of which must be allowed and be there once; `otherwise` without it.
std::vector<std::string> names_of(KindTable& table, std::string_view key,
                                  const std::vector<std::string>& allowed,
                                  std::vector<std::string> otherwise) {
  if (!table.keys().has(key)) {
    return otherwise;
  }
  std::vector<std::string> names = table.keys().texts(key);
  for (const std::string& name : names) {
    if (std::ranges::count(allowed, name) == 0 || std::ranges::count(names, name) > 1) {
      table.keys().fail(key,
                        fmt::format("must be some of: {}; each once", fmt::join(allowed, ", ")));
    }
  }
  return names;
}

}  // namespace

std::unique_ptr<const Trials> read_evaluate(KindTable& table) {
  constexpr double most_runs = 100'000;
  constexpr std::uint64_t greatest_unit = 1'000'000'000;
  std::vector<std::string> rows;
  for (const evaluate::EvaluationRow& row : evaluate::evaluation_rows()) {
    rows.emplace_back(row.name);
  }
  std::vector<std::string> observers;
  for (const replay::ObserverKind& kind : replay::observer_kinds()) {
    observers.emplace_back(kind.name);
  }
  Judging judging{families_of(table),
                  names_of(table, "observers", observers, evaluate::EvaluateOptions{}.observers),
                  names_of(table, "rows", rows, {}),
                  static_cast<int>(table.whole("runs", 0, most_runs, 0)),
                  table.keys().has("wires") ? table.path("wires") : ""};
  const Plan& plan = table.plan();
  if (plan.seed + plan.trials / judging.families.size() > greatest_unit) {
    table.keys().fail("families",
                      fmt::format("the seed of the last unit would be above {}; give a smaller "
                                  "seed, or fewer trials",
                                  greatest_unit));
  }
  if (!judging.wires.empty()) {
    for (std::uint64_t i = 0; i < plan.trials; ++i) {
      const auto count = judging.families.size();
      const hal::Family family = judging.families[static_cast<std::size_t>(i % count)];
      const std::uint64_t seed = plan.seed + i / count;
      table.depends_on("wires", evaluate::calibrated_name(family, seed),
                       wire_path(judging, family, seed));
    }
  }
  return std::make_unique<Evaluations>(plan.seed, std::move(judging));
}

}  // namespace smaservo::campaign
