#include "host-sim/tune/tune_command.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <optional>

#include "firmware/text/settings_file.hpp"
#include "host-sim/tune/tune.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"
#include "model/files/progress.hpp"
#include "model/units.hpp"

namespace smaservo::tune {
namespace {

struct TuneArguments {
  std::string wire{files::default_wire};
  std::vector<std::string> settings;
  std::optional<double> load_N, stress_MPa, current_A;
  std::vector<double> spring;  ///< low and high stress in MPa, and stroke
  double ambient_degC = 25;
  std::string out, report;
  Units units = Units::bench;
  bool json = false;
};

TunedLoad spring(const std::vector<double>& s) {
  require("--spring LOW", s[0], 0, 1e4);
  require("--spring HIGH", s[1], 0, 1e4);
  require("--spring STROKE", s[2], 1e-4, 1);
  if (!(s[0] < s[1])) {
    throw files::UserError(
        fmt::format("--spring {},{},{}: HIGH must be above LOW", s[0], s[1], s[2]));
  }
  return {1e6 * s[0], 1e6 * s[1], s[2]};
}

TunedLoad load(const TuneArguments& a, const Wire<double>& wire) {
  require("--load-N", a.load_N, 0, 1e5);
  require("--stress-MPa", a.stress_MPa, 0, 1e4);
  if (!a.spring.empty()) {
    return spring(a.spring);
  }
  const double stress_Pa = a.load_N ? wire.stress_Pa(*a.load_N) : 1e6 * a.stress_MPa.value_or(0);
  return {stress_Pa, stress_Pa, 0};
}

void require_allowed(const Wire<double>& wire, const TunedLoad& load) {
  const double max_MPa = 1e-6 * wire.limits.stress_Pa;
  for (const double stress_Pa : {load.low_Pa, load.is_spring() ? 0 : load.high_Pa}) {
    if (wire.limits.stress_Pa < stress_Pa) {
      throw files::UserError(
          fmt::format("a load of {:.4g} MPa: the wire bears up to {:.4g} MPa "
                      "(wire.limits.load, {:.4g} N)",
                      1e-6 * stress_Pa, max_MPa, wire.limits.stress_Pa * wire.geometry.area_m2()));
    }
  }
}

/// The name by which the settings file refers to the wire.
std::string based_on(const TuneArguments& a) {
  if (!a.settings.empty() || !a.wire.ends_with(".toml")) {
    return a.settings.empty() ? a.wire : "";
  }
  const std::filesystem::path folder = std::filesystem::path(a.out).parent_path();
  return std::filesystem::proximate(a.wire, folder.empty() ? "." : folder).string();
}

void run(const TuneArguments& a) {
  refuse_to_overwrite(a.out, a.report);
  if (a.wire.ends_with(".toml")) {
    refuse_to_overwrite(a.wire, a.out);
    refuse_to_overwrite(a.wire, a.report);
  }
  const int loads = (a.load_N ? 1 : 0) + (a.stress_MPa ? 1 : 0) + (a.spring.empty() ? 0 : 1);
  if (loads != 1) {
    throw files::UserError("one load is needed: --load-N, --stress-MPa or --spring");
  }
  require("--ambient-degC", a.ambient_degC, -60, 120);
  require("--current-A", a.current_A, 1e-4, 1e3);
  const files::WireDescription description =
      files::load_wire(a.wire, text::parse_settings(a.settings));
  const TunedLoad tuned_load = load(a, description.wire);
  require_allowed(description.wire, tuned_load);
  const TuneTask task{{description.wire, tuned_load, a.ambient_degC + zero_degC_K, 1},
                      a.current_A.value_or(std::numeric_limits<double>::infinity()),
                      24,
                      1};
  const Tuned tuned = [&] {
    files::Progress line("tune");
    return tune(a.wire, based_on(a), task, [&](double share) { line.update_share(share); });
  }();
  if (!a.out.empty()) {
    files::OutputFile file(a.out);
    file.write(tuned_toml(tuned));
    file.commit();
  }
  if (!a.report.empty()) {
    write_tune_report(a.report, tuned, a.units);
  }
  files::print(a.json ? tuned_json(tuned) : tuned_text(tuned),
               a.out == "-" || a.report == "-" ? stderr : stdout);
}

}  // namespace

void add_tune_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "tune", "Proposes gains and limits for a wire under a load, with margins and step response.");
  auto a = std::make_shared<TuneArguments>();
  command->add_option("--wire", a->wire, "preset, or file that ends in .toml")
      ->capture_default_str();
  command
      ->add_option("--set", a->settings,
                   "key=value of the wire, such as wire.length_mm=120; repeatable")
      ->allow_extra_args(false);
  command->add_option("--load-N", a->load_N, "constant load, N");
  command->add_option("--stress-MPa", a->stress_MPa, "the same as a stress, MPa");
  command
      ->add_option("--spring", a->spring,
                   "LOW,HIGH,STROKE of a spring: MPa on the cold wire, MPa on one shorter by the "
                   "strain STROKE")
      ->delimiter(',')
      ->expected(3)
      ->allow_extra_args(false);
  command->add_option("--ambient-degC", a->ambient_degC, "temperature of the air")
      ->capture_default_str();
  command->add_option("--current-A", a->current_A,
                      "greatest current that sensors and converter can take");
  command->add_option("--out", a->out, "proposed settings as TOML");
  add_report_options(*command, a->report, a->units);
  command->add_flag("--json", a->json, "print the numbers as JSON");
  command->callback([a] { run(*a); });
}

}  // namespace smaservo::tune
