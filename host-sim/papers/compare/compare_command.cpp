#include "host-sim/papers/compare/compare_command.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <thread>

#include "firmware/text/settings_file.hpp"
#include "host-sim/checks/findings.hpp"
#include "host-sim/papers/compare/compare.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"
#include "model/files/progress.hpp"

namespace smaservo::compare {
namespace {

struct CompareArguments {
  std::vector<std::string> training, tests;
  std::string from{files::default_wire};
  std::vector<std::string> settings, columns, allowed;
  std::string gru, out, report;
  Units units = Units::bench;
  bool json = false;
  int threads = 0;  ///< 0: as many as there are cores
  std::optional<double> stress_MPa, load_N;
};

bool same_file(const std::string& a, const std::string& b) {
  std::error_code missing;
  return a == b || std::filesystem::equivalent(a, b, missing);
}

void refuse_repeats(const char* option, const std::vector<std::string>& runs) {
  for (auto run = runs.begin(); run != runs.end(); ++run) {
    if (std::any_of(runs.begin(), run, [&](const auto& other) { return same_file(other, *run); })) {
      throw files::UserError(fmt::format("{} {}: is given twice", option, *run));
    }
  }
}

/// Checks that a file can be written before minutes of work.
void require_writable(const std::string& path) {
  std::error_code missing;
  const auto kind = std::filesystem::status(path, missing).type();
  using enum std::filesystem::file_type;
  if (!path.empty() && path != "-" && (kind == not_found || kind == regular || kind == directory)) {
    const files::OutputFile attempt(path);
  }
}

void check_files(const CompareArguments& a) {
  refuse_to_overwrite(a.out, a.report);
  for (const std::vector<std::string>* runs : {&a.training, &a.tests}) {
    for (const std::string& run : *runs) {
      refuse_to_overwrite(run, a.out);
      refuse_to_overwrite(run, a.report);
    }
  }
  if (a.from.ends_with(".toml")) {
    refuse_to_overwrite(a.from, a.out);
    refuse_to_overwrite(a.from, a.report);
  }
  if (!a.gru.empty()) {
    refuse_to_overwrite(a.gru, a.out);
    refuse_to_overwrite(a.gru, a.report);
  }
  refuse_repeats("--train", a.training);
  refuse_repeats("--test", a.tests);
  for (const std::string& run : a.tests) {
    if (std::ranges::any_of(a.training, [&](const auto& one) { return same_file(one, run); })) {
      throw files::UserError(
          fmt::format("--test {}: is a training run, too; a system must not be tested "
                      "on what it has seen",
                      run));
    }
  }
  require_writable(a.out);
  require_writable(a.report);
}

std::vector<identify::Run> read_runs(const std::vector<std::string>& paths,
                                     const identify::RunOptions& options) {
  std::vector<identify::Run> runs;
  runs.reserve(paths.size());
  for (const std::string& path : paths) {
    runs.push_back(identify::read_run(path, options));
  }
  return runs;
}

bool is_lost(const Compared& system) {
  constexpr double lost_percent = 20;
  return system.error.count() == 0 || system.error.mean() > lost_percent;
}

void run(const CompareArguments& a) {
  check_files(a);
  const files::WireDescription from = files::load_wire(a.from, text::parse_settings(a.settings));
  require("--stress-MPa", a.stress_MPa, 0, 1e4);
  require("--load-N", a.load_N, 0, 1e5);
  std::optional<gru::Network> network;
  if (!a.gru.empty()) {
    network = gru::load_network(a.gru);
  }
  identify::RunOptions options{from.wire.geometry, {}, a.load_N, {}};
  if (a.stress_MPa) {
    options.stress_Pa = 1e6 * *a.stress_MPa;
  }
  options.trace.renames = a.columns;
  options.allowed = a.allowed;
  std::vector<identify::Run> training = read_runs(a.training, options);
  std::vector<identify::Run> tests = read_runs(a.tests, options);
  const int threads = a.threads > 0
                          ? a.threads
                          : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  Comparison comparison;
  {
    files::Progress line("compare");
    comparison = compare(
        from, std::move(training), std::move(tests), threads,
        [&](std::string_view system, double share) {
          line.name(fmt::format("compare, {}", system));
          line.update_share(share);
        },
        network);
  }
  if (!a.out.empty()) {
    files::OutputFile file(a.out);
    file.write(comparison_json(comparison));
    file.commit();
  }
  if (!a.report.empty()) {
    write_comparison_report(a.report, comparison, a.units);
  }
  files::print(a.json ? comparison_json(comparison) : comparison_text(comparison),
               a.out == "-" || a.report == "-" ? stderr : stdout);
  if (std::ranges::all_of(comparison.systems, is_lost)) {
    throw files::NoResult(
        "every system is further from the tests than 20 % of the stroke on average; "
        "are these runs of one wire, with one zero, load and length?");
  }
}

}  // namespace

void add_compare_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "compare", "Identifies models and observers on some runs and tests them on others.");
  auto a = std::make_shared<CompareArguments>();
  command->add_option("--train", a->training, "CSV files to identify on, separated by commas")
      ->required()
      ->delimiter(',');
  command->add_option("--test", a->tests, "CSV files to test on, separated by commas")
      ->required()
      ->delimiter(',');
  command->add_option("--from", a->from, "nearest preset, or file that ends in .toml")
      ->capture_default_str();
  command
      ->add_option("--set", a->settings,
                   "key=value of the wire, such as wire.length_mm=120; repeatable")
      ->allow_extra_args(false);
  command->add_option("--gru", a->gru, "also test a recurrent network (host-sim/papers/gru)");
  command->add_option("--column", a->columns, column_help)->allow_extra_args(false);
  command->add_option("--allow", a->allowed, checks::allow_help)->allow_extra_args(false);
  command->add_option("--threads", a->threads, "default: all cores")->check(CLI::Range(1, 1024));
  command->add_option("--load-N", a->load_N, "load of runs without a load, N");
  command->add_option("--stress-MPa", a->stress_MPa, "the same as a stress, MPa")
      ->excludes("--load-N");
  command->add_option("--out", a->out, "numbers as JSON");
  add_report_options(*command, a->report, a->units);
  command->add_flag("--json", a->json, "print the numbers as JSON");
  command->callback([a] { run(*a); });
}

}  // namespace smaservo::compare
