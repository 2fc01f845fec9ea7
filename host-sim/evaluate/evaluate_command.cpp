#include "host-sim/evaluate/evaluate_command.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <thread>

#include "firmware/text/settings_file.hpp"
#include "host-sim/evaluate/closed_loop/closed_loop.hpp"
#include "host-sim/evaluate/closed_loop/random_scenario.hpp"
#include "host-sim/evaluate/evaluate.hpp"
#include "host-sim/evaluate/runs/calibrate.hpp"
#include "host-sim/evaluate/table.hpp"
#include "host-sim/replay/observers.hpp"
#include "host-sim/simulate/closed_loop_run.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"
#include "model/files/progress.hpp"

namespace smaservo::evaluate {
namespace {

struct EvaluateArguments {
  EvaluateOptions options;
  std::vector<std::string> settings;
  std::string out, report, markdown;
  std::string structure{identify::structure_names[0]};
  bool json = false;
  bool closed_loop = false;
  int random = 1000;
  std::optional<std::uint64_t> random_seed, random_from;
};

/// The path of the JSON file; if `out` is a folder, the file in it gets its default name.
std::string json_file(const std::string& out) {
  if (!out.empty() && std::filesystem::is_directory(out)) {
    return (std::filesystem::path(out) / "evaluate.json").string();
  }
  if (!out.empty() && out != "-" && !out.ends_with(".json")) {
    throw files::UserError(fmt::format("--out {}: must be a folder or end in .json", out));
  }
  return out;
}

/// Shows the progress of each stage on a line of its own.
class Stages {
 public:
  void update(std::string_view stage, std::size_t done, std::size_t total) {
    if (!line_ || stage != stage_) {
      stage_ = stage;
      line_.emplace(stage_, total);
    }
    line_->update(done);
  }

 private:
  std::string stage_;
  std::optional<files::Progress> line_;
};

/// Runs only one of the random scenarios.
void run_random_scenario(const EvaluateArguments& a, std::uint64_t seed) {
  const RandomScenario scenario =
      random_scenario(calibrated_units(a.options.units, a.options.seed, a.options.wires), seed);
  const simulate::LoopRunResult result = simulate::run_closed_loop(scenario.loop, {.out = a.out});
  files::print(simulate::summary(scenario.loop, result), a.out == "-" ? stderr : stdout);
}

/// The output files for numbers and table. They are opened before the evaluation, which may take an
/// hour.
struct Destination {
  std::optional<files::OutputFile> json;
  std::optional<TableFile> table;

  void write_numbers(const std::string& numbers) {
    if (json) {
      json->write(numbers);
      json->commit();
    }
  }
  /// Comes last: where the table's file has lost its marks meanwhile, the results are not lost.
  void write_table(const std::string& markdown) const {
    if (table) {
      table->rewrite(markdown);
    }
  }
};

/// Makes the table of control (--closed-loop).
void run_closed_loop(const EvaluateArguments& a, Destination& destination) {
  ClosedLoopOptions options;
  options.units = a.options.units;
  options.runs = a.options.runs > 0 ? a.options.runs : options.runs;
  options.seed = a.options.seed;
  options.threads = a.options.threads;
  options.wires = a.options.wires;
  options.random = a.random;
  options.random_from = a.random_from;
  Stages stages;
  options.progress = [&](std::string_view stage, std::size_t done, std::size_t total) {
    stages.update(stage, done, total);
  };
  const ClosedLoopEvaluation evaluation = evaluate_closed_loop(options);
  const std::string json = closed_loop_json(evaluation);
  const std::string markdown = closed_loop_markdown(evaluation);
  destination.write_numbers(json);
  files::print(a.json ? json : markdown, a.out == "-" ? stderr : stdout);
  destination.write_table(markdown);
}

void run(EvaluateArguments& a) {
  if (a.random_seed) {
    run_random_scenario(a, *a.random_seed);
    return;
  }
  const std::string out = json_file(a.out);
  refuse_to_overwrite(out, a.report);
  refuse_to_overwrite(a.markdown, out);
  refuse_to_overwrite(a.markdown, a.report);
  Destination destination;
  if (!out.empty()) {
    destination.json.emplace(out);
  }
  if (!a.markdown.empty()) {
    const bool usual = a.options.families == EvaluateOptions{}.families;
    destination.table.emplace(a.markdown, a.random_from ? "random scenarios"
                                          : usual       ? "evaluate"
                                                        : "other families");
  }
  if (a.closed_loop) {
    run_closed_loop(a, destination);
    return;
  }
  a.options.settings = text::parse_settings(a.settings);
  a.options.structure = identify::structure_named(a.structure);
  Evaluation evaluation;
  {
    Stages stages;
    a.options.progress = [&](std::string_view stage, std::size_t done, std::size_t total) {
      stages.update(stage, done, total);
    };
    evaluation = evaluate(a.options);
  }
  destination.write_numbers(table_json(evaluation));
  if (!a.report.empty()) {
    write_table_report(a.report, evaluation);
  }
  files::print(a.json ? table_json(evaluation) : table_text(evaluation),
               out == "-" || a.report == "-" ? stderr : stdout);
  destination.write_table(table_markdown(evaluation));
}

}  // namespace

void add_evaluate_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "evaluate", "Judges observers by many simulated runs of wires that no observer knows.");
  auto a = std::make_shared<EvaluateArguments>();
  EvaluateOptions& options = a->options;
  options.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  std::vector<std::string> observers;
  for (const replay::ObserverKind& kind : replay::observer_kinds()) {
    observers.emplace_back(kind.name);
  }
  std::vector<std::string> families(hal::families.size());
  std::ranges::transform(hal::families, families.begin(), hal::family_name);
  std::vector<std::string> rows;
  for (const EvaluationRow& row : evaluation_rows()) {
    rows.emplace_back(row.name);
  }
  command
      ->add_option_function<std::vector<std::string>>(
          "--family",
          [a](const std::vector<std::string>& names) {
            a->options.families.clear();
            for (const std::string& name : names) {
              a->options.families.push_back(
                  *std::ranges::find(hal::families, name, hal::family_name));
            }
          },
          "families of plants; default: ihyp and sublayers. free-energy and smooth-hardening are "
          "kept for tests and never used to choose anything")
      ->delimiter(',')
      ->check(CLI::IsMember(families));
  command->add_option("--units", options.units, "wires of each family")->capture_default_str();
  command->add_option(
      "--runs", options.runs,
      fmt::format("runs of each row, of all units together; default: for each unit 84 "
                  "of disturbed, {} of the others; with --closed-loop {} in all",
                  EvaluationRow{}.runs, ClosedLoopOptions{}.runs));
  command
      ->add_option("--seed", options.seed,
                   "seed of the first unit; observers are tuned with 1 to 99")
      ->capture_default_str();
  command->add_option("--threads", options.threads)->capture_default_str();
  const CLI::Option* const observer =
      command->add_option("--observer", options.observers, "repeatable")
          ->check(CLI::IsMember(observers))
          ->allow_extra_args(false)
          ->capture_default_str();
  command
      ->add_option("--observer-program", options.programs,
                   "path of a program of yours to judge as an observer, beside those of "
                   "--observer if that is given; repeatable; protocol: "
                   "host-sim/evaluate/README.md")
      ->allow_extra_args(false);
  command->add_option("--set", a->settings, "key=value of observer or measurement; repeatable")
      ->allow_extra_args(false);
  command->add_option("--row", options.rows, "rows of the table; default: all")
      ->delimiter(',')
      ->check(CLI::IsMember(rows))
      ->allow_extra_args(false);
  command->add_option("--wires", options.wires,
                      "folder of the calibrated wires; a wire that is in it is not "
                      "calibrated again");
  command->add_option("--structure", a->structure, "of the calibrations, as of identify")
      ->check(CLI::IsMember(std::vector<std::string>(identify::structure_names.begin(),
                                                     identify::structure_names.end())))
      ->capture_default_str();
  command->add_option("--out", a->out, "numbers as JSON: file, folder, or - for standard output");
  command->add_option("--report", a->report, "table as one HTML file");
  command->add_option("--markdown", a->markdown, "Markdown file whose table is replaced");
  command->add_flag("--json", a->json, "print the numbers as JSON");
  command
      ->add_flag("--closed-loop", a->closed_loop,
                 "judges the firmware's control in place of its observers")
      ->excludes("--family", "--row", "--observer", "--observer-program", "--set", "--report",
                 "--structure");
  command->add_option("--random", a->random, "number of random scenarios of --closed-loop")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  command
      ->add_option("--random-from", a->random_from,
                   "of --closed-loop: only the random scenarios, of this seed and the next ones")
      ->needs("--closed-loop");
  command->add_option("--random-seed", a->random_seed,
                      "runs only the random scenario of this seed; --out is its trace");
  command->callback([a, observer] {
    if (!a->options.programs.empty() && observer->count() == 0) {
      a->options.observers.clear();
    }
    run(*a);
  });
}

}  // namespace smaservo::evaluate
