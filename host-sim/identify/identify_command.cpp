#include "host-sim/identify/identify_command.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <thread>

#include "firmware/text/settings_file.hpp"
#include "host-sim/checks/findings.hpp"
#include "host-sim/identify/fitted_wire.hpp"
#include "host-sim/identify/report.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"
#include "model/files/progress.hpp"

namespace smaservo::identify {
namespace {

struct IdentifyArguments {
  std::vector<std::string> runs, held_out;
  std::string from{files::default_wire};
  std::vector<std::string> settings, columns, allowed;
  std::string out, report;
  Units units = Units::bench;
  bool json = false;
  bool circuit = false;
  std::string structure{structure_names[0]};
  bool lenient = false;
  bool imposed_strain = false;
  int threads = 0;  ///< 0: as many as there are cores
  std::optional<double> stress_MPa, load_N;
};

/// Turns the first Ctrl-C into a request to stop; a second one ends the program at once.
class Interrupt {
 public:
  Interrupt() {
    asked() = 0;
    struct sigaction action{};
    action.sa_handler = [](int) { asked() = 1; };
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    sigaction(SIGINT, &action, &before_);
  }
  ~Interrupt() { sigaction(SIGINT, &before_, nullptr); }
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  static volatile std::sig_atomic_t& asked() {
    static volatile std::sig_atomic_t flag = 0;
    return flag;
  }

 private:
  struct sigaction before_{};
};

void check_files(const IdentifyArguments& a) {
  if (!a.out.ends_with(".toml")) {
    throw files::UserError(fmt::format("--out {}: the name of a wire file ends in .toml", a.out));
  }
  std::vector<std::string> runs = a.runs;
  runs.insert(runs.end(), a.held_out.begin(), a.held_out.end());
  for (auto run = runs.begin(); run != runs.end(); ++run) {
    refuse_to_overwrite(*run, a.out);
    refuse_to_overwrite(*run, a.report);
    for (auto other = runs.begin(); other != run; ++other) {
      refuse_to_overwrite(*other, *run);
    }
  }
  if (a.from.ends_with(".toml")) {
    refuse_to_overwrite(a.from, a.out);
    refuse_to_overwrite(a.from, a.report);
  }
  refuse_to_overwrite(a.out, a.report);
}

std::vector<Run> read_runs(const IdentifyArguments& a, const std::vector<std::string>& paths,
                           const Geometry<double>& geometry) {
  require("--stress-MPa", a.stress_MPa, 0, 1e4);
  require("--load-N", a.load_N, 0, 1e5);
  RunOptions options{geometry, {}, a.load_N, {}};
  if (a.stress_MPa) {
    options.stress_Pa = 1e6 * *a.stress_MPa;
  }
  options.trace.renames = a.columns;
  options.allowed = a.allowed;
  options.trace.lenient = a.lenient;
  options.imposed_strain = a.imposed_strain;
  std::vector<Run> runs;
  runs.reserve(paths.size());
  for (const std::string& path : paths) {
    runs.push_back(read_run(path, options));
  }
  return runs;
}

void fit(const IdentifyArguments& a, const Wire<double>& from, Identification& all) {
  const Interrupt interrupt;
  files::Progress progress("fit");
  FitOptions options;
  options.circuit = a.circuit;
  options.structure = structure_named(a.structure);
  options.threads = a.threads > 0
                        ? a.threads
                        : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  options.proceed = [&](const FitProgress& at) {
    progress.update_share(at.share);
    progress.name(fmt::format("fit, {}", at.stage));
    return Interrupt::asked() == 0;
  };
  all.fit = fit_wire(from, all.runs, options);
  if (!all.fit.interrupted) {
    all.held_out = held_out(all.fit, all.held_out_runs, options);
  }
}

void run(const IdentifyArguments& a) {
  const auto start = std::chrono::steady_clock::now();
  check_files(a);
  const files::WireDescription from = files::load_wire(a.from, text::parse_settings(a.settings));
  files::OutputFile file(a.out);
  Identification all;
  all.from = from.name;
  all.out = a.out;
  all.runs = read_runs(a, a.runs, from.wire.geometry);
  all.held_out_runs = read_runs(a, a.held_out, from.wire.geometry);
  if (a.imposed_strain &&
      std::ranges::find(all.runs, RunKind::imposed, &Run::kind) == all.runs.end()) {
    throw files::UserError(
        "--imposed-strain: none of the runs has what it takes: time, power (or current and "
        "voltage), "
        "strain and load; leave it out for runs in a bath, in a calorimeter or at rest");
  }
  fit(a, from.wire, all);
  all.wire = fitted_wire(from, all.fit, std::filesystem::path(a.out).stem().string());
  for (const Run& run : all.runs) {
    all.classics.push_back(fit_classics(run));
  }
  all.elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  file.write(files::to_toml(all.wire));
  file.commit();
  if (!a.report.empty()) {
    write_fit_report(a.report, all, a.units);
  }
  files::print(a.json ? fit_json(all) : fit_summary(all), a.report == "-" ? stderr : stdout);
  if (all.fit.interrupted) {
    // The program ends by the signal itself, so that a shell or script sees that it was
    // interrupted.
    std::fflush(stdout);
    std::raise(SIGINT);
  }
  if (!all.fit.converged) {
    throw files::NoResult(
        fmt::format("{}: the fit has not converged after {} steps; the file is the best so far. "
                    "Give it as --from to go on",
                    a.out, all.fit.iterations));
  }
}

}  // namespace

void add_identify_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("identify", "Fits a wire's parameters to measured runs of it.");
  auto a = std::make_shared<IdentifyArguments>();
  command
      ->add_option("RUN", a->runs,
                   "CSV files of runs: in a bath, heated by current, settled states, calorimetry")
      ->required();
  command->add_option("--out", a->out, "wire file to write, ends in .toml")->required();
  command->add_option("--from", a->from, "nearest preset, or file that ends in .toml")
      ->capture_default_str();
  command
      ->add_option("--set", a->settings,
                   "key=value of the wire, such as wire.length_mm=120; repeatable")
      ->allow_extra_args(false);
  add_report_options(*command, a->report, a->units);
  command->add_flag("--json", a->json, "print the numbers as JSON");
  command->add_flag("--circuit", a->circuit,
                    "also fit the resistance of the leads and the gain of the load cell");
  command
      ->add_option("--structure", a->structure,
                   "ends of the curves and order of the inner loops: paper-000, fitted only where "
                   "--from has others than the paper; ordered, fitted; auto, ordered if with it "
                   "the observer errs clearly less in runs left out of the fit")
      ->check(
          CLI::IsMember(std::vector<std::string>(structure_names.begin(), structure_names.end())))
      ->capture_default_str();
  command
      ->add_option("--held-out", a->held_out,
                   "a run that is not fitted but predicted, to judge the fit by; repeatable")
      ->allow_extra_args(false);
  command->add_option("--threads", a->threads, "default: all cores")->check(CLI::Range(1, 1024));
  command->add_option("--load-N", a->load_N, "load of runs without a load, N");
  command->add_option("--stress-MPa", a->stress_MPa, "the same as a stress, MPa")
      ->excludes("--load-N");
  command->add_flag("--imposed-strain", a->imposed_strain,
                    "a test frame set the strain of the runs in time; fits the stress");
  command->add_option("--column", a->columns, column_help)->allow_extra_args(false);
  command->add_flag("--lenient", a->lenient, "skip and count bad rows instead of refusing them");
  command->add_option("--allow", a->allowed, checks::allow_help)->allow_extra_args(false);
  command->callback([a] { run(*a); });
}

}  // namespace smaservo::identify
