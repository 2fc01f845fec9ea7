#include "host-sim/commission/commission_command.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <thread>

#include "firmware/text/settings_file.hpp"
#include "host-sim/can/commands/session.hpp"
#include "host-sim/checks/findings.hpp"
#include "host-sim/commission/fitted_run.hpp"
#include "host-sim/commission/live/live.hpp"
#include "host-sim/commission/output.hpp"
#include "host-sim/report/html.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"
#include "model/files/progress.hpp"
#include "model/units.hpp"

namespace smaservo::commission {
namespace {

struct CommissionArguments {
  std::string run;  ///< read, or with --can written
  std::string record;
  std::string from{files::default_wire};
  std::vector<std::string> settings, columns, allowed, anchors;
  std::string anchors_file, out, report;
  std::string zero = "common";
  double anchor_sd_mm = 1e3 * usual_anchor_sd_m;
  double length_sd_mm = 1e3 * CommissionOptions{}.length_sd_m;
  LiveOptions live;
  double pace = 1;
  bool no_questions = false;
  Units units = Units::bench;
  bool json = false, lenient = false;
  int threads = 0;  ///< 0: as many as there are cores
  std::optional<double> stress_MPa, load_N, ambient_degC;
};

/// Before a wire is heated or fitted.
void require_folder(const char* option, const std::string& file) {
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  if (!file.empty() && !folder.empty() && !std::filesystem::is_directory(folder)) {
    throw files::UserError(
        fmt::format("{} {}: there is no folder {}", option, file, folder.string()));
  }
}

void check_files(const CommissionArguments& a) {
  require_folder("--out", a.out);
  require_folder("--report", a.report);
  require_folder("--record", a.record);
  require_folder("--anchors", a.anchors_file);
  if (!a.out.empty() && !a.out.ends_with(".toml")) {
    throw files::UserError(fmt::format("--out {}: the name of a wire file ends in .toml", a.out));
  }
  for (const std::string* input : {&a.run, &a.anchors_file, &a.from}) {
    refuse_to_overwrite(*input, a.out);
    refuse_to_overwrite(*input, a.report);
  }
  refuse_to_overwrite(a.out, a.report);
  refuse_to_overwrite(a.run, a.anchors_file);
}

identify::Run read(const CommissionArguments& a, const Geometry<double>& geometry) {
  require("--stress-MPa", a.stress_MPa, 0, 1e4);
  require("--load-N", a.load_N, 0, 1e5);
  identify::RunOptions options{geometry, {}, a.load_N, {}};
  if (a.stress_MPa) {
    options.stress_Pa = 1e6 * *a.stress_MPa;
  }
  options.trace.renames = a.columns;
  options.trace.lenient = a.lenient;
  options.allowed = a.allowed;
  identify::Run run = heated_run(a.run, options);
  if (!run.strain.empty()) {
    files::complain("host-sim",
                    fmt::format("{}: has a strain or displacement, which is not used; `host-sim "
                                "identify` learns far more from it",
                                run.name));
  }
  return run;
}

std::vector<Anchor> anchors_of(const CommissionArguments& a) {
  const double sd_m = 1e-3 * a.anchor_sd_mm;
  std::vector<Anchor> anchors;
  if (!a.anchors_file.empty()) {
    anchors = read_anchors(a.anchors_file, sd_m);
  }
  for (const std::string& text : a.anchors) {
    anchors.push_back(parse_anchor(text, sd_m));
  }
  return anchors;
}

/// Fits the wire to the recording.
void fit(const CommissionArguments& a, const std::vector<Anchor>& anchors) {
  const files::WireDescription from = files::load_wire(a.from, text::parse_settings(a.settings));
  const identify::Run recorded = read(a, from.wire.geometry);
  CommissionOptions options;
  options.zero = a.zero == "length" ? Zero::length : Zero::common;
  options.length_sd_m = 1e-3 * a.length_sd_mm;
  options.threads = a.threads > 0
                        ? a.threads
                        : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  if (a.ambient_degC) {
    options.ambient_K = *a.ambient_degC + zero_degC_K;
  }
  const Commissioning all = [&] {
    files::Progress progress("commission");
    options.proceed = [&](double share) {
      progress.update_share(share);
      return true;
    };
    return fitted_run(from, recorded, anchors, options, a.run, a.out);
  }();
  const files::WireDescription wire =
      commissioned_wire(all, std::filesystem::path(a.out).stem().string());
  if (!a.report.empty()) {
    report::write_html(a.report, "commission",
                       report::plots_html(panels(all), a.units) +
                           report::listing_html("What was learned", text(all)));
  }
  files::OutputFile file(a.out);
  file.write(files::to_toml(wire));
  file.commit();
  files::print(a.json ? json(all) : text(all), a.report == "-" ? stderr : stdout);
}

/// Records the run and its readings, and leaves them in their files.
std::vector<Anchor> record(CommissionArguments& a) {
  if (a.run == "-" || a.run.ends_with(".mcap")) {
    throw files::UserError(
        fmt::format("--record {}: must be the name of a file, and the run is CSV", a.run));
  }
  a.live.path = a.run;
  a.live.questions = !a.no_questions;
  a.live.reading_sd_m = 1e-3 * a.anchor_sd_mm;
  a.live.times = LevelTimes{}.times(a.pace);
  const LiveRun run = record_live(a.live);
  if (!a.anchors_file.empty()) {
    files::OutputFile file(a.anchors_file);
    file.write(anchors_csv(run.anchors));
    file.commit();
  }
  for (const std::string& note : run.notes) {
    files::complain("host-sim", note);
  }
  files::print(fmt::format("{}: {} rows, {:.0f} rows/s, {} left out, {} readings\n",
                           files::printable(run.path), run.rows, 1 / run.period_s, run.left_out,
                           run.anchors.size()),
               a.json ? stderr : stdout);
  return run.anchors;
}

void run(CommissionArguments& a, bool live) {
  check_files(a);
  require("--ambient-degC", a.ambient_degC, -60, 100);
  require("--anchor-sd-mm", a.anchor_sd_mm, 1e-3, 1e3);
  require("--length-sd-mm", a.length_sd_mm, 1e-3, 1e3);
  // Before a wire is heated: what is typed wrong must not cost a run.
  std::vector<Anchor> anchors = live ? std::vector<Anchor>() : anchors_of(a);
  if (!a.out.empty()) {
    files::load_wire(a.from, text::parse_settings(a.settings));
  }
  if (live) {
    anchors = record(a);
  }
  if (!a.out.empty()) {
    fit(a, anchors);
  }
}

void add_live_options(CLI::App& command, CommissionArguments& a) {
  CLI::Option* can =
      command.add_option("--can", a.live.can,
                         "record the run from a servo on this bus: can0, vcan0, ...; "
                         "udp[:GROUP[:PORT]]");
  command.add_option("--record", a.record, "file for that run, CSV")->needs(can);
  can->needs("--record");
  command.add_option("--node", a.live.node, "node-id of the servo")
      ->capture_default_str()
      ->check(CLI::Range(1, 127))
      ->needs(can);
  command.add_option("--key", a.live.key, "key of an access level (2003h)")->needs(can);
  command.add_option("--timeout", a.live.timeout_s, "longest wait for an answer, s")
      ->capture_default_str()
      ->check(can::seconds_of(0.01, 60))
      ->needs(can);
  command
      .add_option("--ask", a.live.asks,
                  "readings of the heated wire that are asked for; each holds the heat")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{0}, most_questions))
      ->needs(can);
  command.add_flag("--no-questions", a.no_questions, "asks for no reading")->needs(can);
  command
      .add_option("--pace", a.pace, "factor on the durations of all levels: more for a thick wire")
      ->capture_default_str()
      ->check(can::seconds_of(0.05, 2))
      ->needs(can);
}

}  // namespace

void add_commission_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "commission",
      "Fits a type's wire to one run without a displacement sensor, and to a few readings.");
  auto a = std::make_shared<CommissionArguments>();
  CLI::Option* recorded =
      command->add_option("RUN", a->run,
                          "recording of a wire that is heated from the cold through its "
                          "transformation and cools again, twice: time, current, voltage, load");
  CLI::Option* out =
      command->add_option("--out", a->out, "wire file to write, ends in .toml; needed with RUN");
  recorded->needs(out);
  command->add_option("--from", a->from, "the wire's type: preset, or file that ends in .toml")
      ->capture_default_str();
  command
      ->add_option("--set", a->settings,
                   "key=value of the wire, such as wire.length_mm=120; repeatable")
      ->allow_extra_args(false);
  command
      ->add_option("--anchor", a->anchors,
                   "TIME_S,DISPLACEMENT_MM[,SD_MM]: where the wire's end was; grows as the wire "
                   "gets shorter; repeatable")
      ->allow_extra_args(false);
  command->add_option("--anchors", a->anchors_file,
                      "file with such readings: time_s, displacement_mm, perhaps sd_mm; with "
                      "--can it is written");
  command
      ->add_option("--anchor-sd-mm", a->anchor_sd_mm,
                   "standard deviation of a reading without one, mm")
      ->capture_default_str();
  command
      ->add_option("--zero", a->zero,
                   "where the readings have their zero: common, anywhere, the same for all; "
                   "length, where the wire has the length of the wire file")
      ->check(CLI::IsMember(std::vector<std::string>{"common", "length"}))
      ->capture_default_str();
  command
      ->add_option("--length-sd-mm", a->length_sd_mm,
                   "standard deviation of wire.length, for --zero length, mm")
      ->capture_default_str();
  command->add_option("--ambient-degC", a->ambient_degC,
                      "temperature of the air, where RUN does not have it");
  add_report_options(*command, a->report, a->units);
  command->add_flag("--json", a->json, "print the numbers as JSON");
  command->add_option("--threads", a->threads, "default: all cores")->check(CLI::Range(1, 1024));
  command->add_option("--load-N", a->load_N, "load, where RUN has none, N");
  command->add_option("--stress-MPa", a->stress_MPa, "the same as a stress, MPa")
      ->excludes("--load-N");
  command->add_option("--column", a->columns, column_help)->allow_extra_args(false);
  command->add_flag("--lenient", a->lenient, "skip and count bad rows instead of refusing them");
  command->add_option("--allow", a->allowed, checks::allow_help)->allow_extra_args(false);
  add_live_options(*command, *a);
  command->callback([a, recorded, out] {
    const bool live = !a->live.can.empty();
    if (out->count() > 0 && a->out.empty()) {
      throw CLI::ValidationError("--out", "needs the name of a file");
    }
    if (live == (recorded->count() > 0)) {
      throw CLI::ValidationError("commission", live ? "RUN and --can exclude each other"
                                                    : "give RUN, or --can and --record");
    }
    if (live && !a->anchors.empty()) {
      throw CLI::ValidationError("--anchor", "excludes --can, which asks for readings");
    }
    if (live) {
      a->run = a->record;
    }
    run(*a, live);
  });
}

}  // namespace smaservo::commission
