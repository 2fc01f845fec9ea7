#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <thread>

#include "host-sim/commands.hpp"
#include "host-sim/compare/compare.hpp"
#include "host-sim/output_file.hpp"
#include "host-sim/progress.hpp"

namespace smaservo {
namespace {

struct Arguments {
  std::vector<std::string> training, tests;
  std::string from{default_wire};
  std::vector<std::string> settings, columns;
  std::string out, report;
  bool json = false;
  int threads = 0;  ///< 0: as many as cores
};

void check_files(const Arguments& a) {
  refuse_to_overwrite(a.out, a.report);
  for (const std::vector<std::string>* runs : {&a.training, &a.tests}) {
    for (const std::string& run : *runs) {
      refuse_to_overwrite(run, a.out);
      refuse_to_overwrite(run, a.report);
    }
  }
  for (const std::string& run : a.tests) {
    if (std::ranges::count(a.training, run) > 0) {
      throw UserError(
          fmt::format("--test {}: is a training run, too; a system may not be asked "
                      "about what it has seen",
                      run));
    }
  }
}

std::vector<Run> read_runs(const std::vector<std::string>& paths, const RunOptions& options) {
  std::vector<Run> runs;
  runs.reserve(paths.size());
  for (const std::string& path : paths) {
    runs.push_back(read_run(path, options));
  }
  return runs;
}

void run(const Arguments& a) {
  check_files(a);
  const WireDescription from = load_wire(a.from, parse_settings(a.settings));
  RunOptions options{from.wire.geometry, {}, {}, {}};
  options.trace.renames = a.columns;
  std::vector<Run> training = read_runs(a.training, options);
  std::vector<Run> tests = read_runs(a.tests, options);
  const int threads = a.threads > 0
                          ? a.threads
                          : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  Comparison comparison;
  {
    std::optional<Progress> line;
    comparison =
        compare(from, std::move(training), std::move(tests), threads, [&](std::string_view system) {
          line.emplace(std::string(system), 0);
          line->step(0);
        });
  }
  if (!a.out.empty()) {
    OutputFile file(a.out);
    file.write(comparison_json(comparison));
    file.commit();
  }
  if (!a.report.empty()) {
    write_comparison_report(a.report, comparison);
  }
  fmt::print(a.out == "-" || a.report == "-" ? stderr : stdout, "{}",
             a.json ? comparison_json(comparison) : comparison_text(comparison));
}

}  // namespace

void add_compare_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "compare", "Identifies models and observers on some runs and asks them about others.");
  auto a = std::make_shared<Arguments>();
  command->add_option("--train", a->training, "CSV files to identify on, with commas between")
      ->required()
      ->delimiter(',');
  command->add_option("--test", a->tests, "CSV files to ask about, with commas between")
      ->required()
      ->delimiter(',');
  command->add_option("--from", a->from, "nearest preset, or file that ends in .toml")
      ->capture_default_str();
  command->add_option("--set", a->settings, "key=value of the wire, as its length; repeatable")
      ->allow_extra_args(false);
  command
      ->add_option("--column", a->columns,
                   "NAME=COLUMN or NAME=COLUMN*FACTOR: what a column is; repeatable")
      ->allow_extra_args(false);
  command->add_option("--threads", a->threads, "default: all cores")->check(CLI::Range(1, 1024));
  command->add_option("--out", a->out, "numbers as JSON");
  command->add_option("--report", a->report, "report as one HTML file");
  command->add_flag("--json", a->json, "print the numbers as JSON");
  command->callback([a] { run(*a); });
}

}  // namespace smaservo
