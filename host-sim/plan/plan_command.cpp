#include "host-sim/plan/plan_command.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "firmware/text/settings_file.hpp"
#include "host-sim/plan/plan.hpp"
#include "host-sim/report/html.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"
#include "model/files/progress.hpp"
#include "model/files/text_table.hpp"
#include "model/units.hpp"

namespace smaservo::plan {
namespace {

struct PlanArguments {
  std::string wire, out{"-"}, report;
  Units units = Units::bench;
  std::vector<std::string> settings;
  std::vector<double> loads_N, stresses_MPa;
  double duration_s = 60;
  bool json = false;
  int threads = 0;  ///< 0: as many as there are cores
};

/// The content of all outputs.
struct Planned {
  const PlanArguments& arguments;
  Wire<double> wire;
  Plan plan;
};

std::string name_of(const PlannedRun& run) {
  return fmt::format("{:.4g}MPa", 1e-6 * run.stress_Pa);
}

double load_N(const Planned& p, const PlannedRun& run) {
  return run.stress_Pa * p.wire.geometry.area_m2();
}

double stroke(const PlannedRun& run) {
  const auto [low, high] = std::ranges::minmax(run.strain);
  return high - low;
}

double ratio(const Plan& plan) {
  return std::exp(mean_logarithm(plan, &ExpectedParameter::triangle) -
                  mean_logarithm(plan, &ExpectedParameter::plan));
}

std::string csv(const Plan& plan) {
  std::string text = "time_s";
  for (const PlannedRun& run : plan.runs) {
    text += plan.runs.size() == 1 ? ",current_A" : ",current_A_" + name_of(run);
  }
  text += '\n';
  for (std::size_t i = 0; i < plan.runs.front().current_A.size(); ++i) {
    text += fmt::format("{:.2f}", static_cast<double>(i) * plan.step_s);
    for (const PlannedRun& run : plan.runs) {
      text += fmt::format(",{:.6f}", run.current_A[i]);
    }
    text += '\n';
  }
  return text;
}

/// A deviation in the unit of the parameter; relative for a factor, in logits for a share.
std::string deviation_text(const identify::FitParameter& p, double share) {
  switch (p.form) {
    case identify::Form::sum:
      return fmt::format("{:.3g} {}", share * p.sd / p.scale, p.unit == "degC" ? "K" : p.unit);
    case identify::Form::factor:
      return fmt::format("{:.2g} %", 100 * share * p.sd);
    case identify::Form::share:
      break;
  }
  return fmt::format("{:.2g} logit", share * p.sd);
}

std::string instructions(const Planned& p) {
  std::vector<std::string> loads, files;
  for (const PlannedRun& run : p.plan.runs) {
    loads.push_back(fmt::format("{:.4g} N", load_N(p, run)));
    files.push_back(name_of(run) + ".csv");
  }
  std::string settings;
  for (const std::string& setting : p.arguments.settings) {
    settings += " --set " + files::printable(setting);
  }
  return fmt::format(
      "1. Hang {} on the wire, one after the other. Heat it once, let it cool until nothing moves, "
      "then run the column of that load.\n"
      "2. Record in still air, 100 rows/s or more, a file for each load: time_s, current_A, "
      "voltage_V (at "
      "the wire), load_N, displacement_mm, ambient_degC.\n"
      "3. host-sim identify --from {}{} --out mine.toml {}\n",
      fmt::join(loads, ", "), files::printable(p.arguments.wire), settings, fmt::join(files, " "));
}

files::TextTable runs(const Planned& p) {
  files::TextTable table({{"run", "", "name"},
                          {.key = "stress_MPa"},
                          {"load in N", "{:.4g}", "load_N"},
                          {"peak in mA", "{:.4g}", "peak_A", 1e3},
                          {"of limit", "{:.2f}"},
                          {"hottest °C", "{:.1f}", "hottest_degC"},
                          {"stroke in %", "{:.2f}", "stroke", 100}});
  for (const PlannedRun& run : p.plan.runs) {
    const double peak_A = std::ranges::max(run.current_A);
    table.add({name_of(run), 1e-6 * run.stress_Pa, load_N(p, run), peak_A,
               peak_A / p.wire.limits.current_A, std::ranges::max(run.temperature_K) - zero_degC_K,
               stroke(run)});
  }
  return table;
}

files::TextTable deviations(const Planned& p) {
  files::TextTable table({{"expected deviation", "", "key"},
                          {.key = "prior_sd"},
                          {.key = "triangle"},
                          {.key = "plan"},
                          {.key = "determined"},
                          {"prior", "{}"},
                          {"triangle", "{}"},
                          {"plan", "{}"},
                          {""}});
  for (const ExpectedParameter& e : p.plan.parameters) {
    const bool determined = e.plan < 0.5;
    table.add({e.parameter.key, e.parameter.sd, e.triangle, e.plan, determined,
               deviation_text(e.parameter, 1), deviation_text(e.parameter, e.triangle),
               deviation_text(e.parameter, e.plan), determined ? "" : "not determined"});
  }
  return table;
}

std::string summary(const Planned& p) {
  const Plan& plan = p.plan;
  return fmt::format(
             "{}\n{}\ndetermined, of {}: {} by the plan, {} by a triangle of the current; "
             "deviations "
             "smaller by a factor of {:.2f} (geometric mean)\n",
             runs(p).text(), deviations(p).text(), plan.parameters.size(),
             determined(plan, &ExpectedParameter::plan),
             determined(plan, &ExpectedParameter::triangle), ratio(plan)) +
         instructions(p);
}

std::string json(const Planned& p) {
  nlohmann::ordered_json all{{"wire", p.arguments.wire},
                             {"duration_s", p.arguments.duration_s},
                             {"step_s", p.plan.step_s},
                             {"runs", runs(p).json()},
                             {"parameters", deviations(p).json()}};
  all["determined"] = {{"triangle", determined(p.plan, &ExpectedParameter::triangle)},
                       {"plan", determined(p.plan, &ExpectedParameter::plan)}};
  all["ratio"] = ratio(p.plan);
  return files::json_text(all);
}

std::vector<report::Panel> plots(const Plan& plan) {
  std::vector<report::Panel> all;
  for (const PlannedRun& run : plan.runs) {
    const std::string name = name_of(run);
    std::vector<double> time_s(run.current_A.size());
    for (std::size_t i = 0; i < time_s.size(); ++i) {
      time_s[i] = static_cast<double>(i + 1) * plan.step_s;
    }
    const report::Column time = report::column(std::move(time_s));
    const auto add = [&](const char* what, const char* label, report::Column values) {
      const bool half = !all.empty() && all.back().link == name;
      all.push_back(
          {.title = fmt::format("{}: {}", name, what),
           .caption = half ? "as the wire's own model expects it" : "",
           .half_width = half,
           .height = 260,
           .x = {.label = "time in s"},
           .y = {.label = label},
           .link = name,
           .series = {{.name = what, .colour = "estimate", .x = time, .y = std::move(values)}}});
    };
    add("current", "current in mA",
        report::column_of(run.current_A, [](double A) { return 1e3 * A; }));
    add("temperature", "temperature in °C",
        report::column_of(run.temperature_K, [](double K) { return K - zero_degC_K; }));
    add("strain", "strain in %", report::column_of(run.strain, [](double e) { return 100 * e; }));
  }
  return all;
}

Plan plan(const PlanArguments& a, const Wire<double>& wire) {
  PlanOptions options;
  options.duration_s = a.duration_s;
  options.threads = a.threads > 0
                        ? a.threads
                        : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  for (const double load_N : a.loads_N) {
    options.stresses_Pa.push_back(wire.stress_Pa(load_N));
  }
  for (const double stress_MPa : a.stresses_MPa) {
    options.stresses_Pa.push_back(1e6 * stress_MPa);
  }
  std::unique_ptr<files::Progress> progress;
  options.progress = [&](std::size_t done, std::size_t total) {
    if (!progress) {
      progress = std::make_unique<files::Progress>("profiles tried", total);
    }
    progress->update(done);
  };
  return plan_runs(wire, options);
}

void run(const PlanArguments& a) {
  require("--duration-s", a.duration_s, 10, 600);
  refuse_to_overwrite(a.out, a.report);
  if (a.out == "-" && a.report == "-") {
    throw files::UserError("--out and --report cannot both be standard output");
  }
  if (a.wire.ends_with(".toml")) {
    refuse_to_overwrite(a.wire, a.out);
    refuse_to_overwrite(a.wire, a.report);
  }
  const Wire<double> wire = files::load_wire(a.wire, text::parse_settings(a.settings)).wire;
  const Planned planned{a, wire, plan(a, wire)};
  files::OutputFile file(a.out);
  file.write(csv(planned.plan));
  file.commit();
  if (!a.report.empty()) {
    report::write_html(a.report, "calibrate-plan " + a.wire,
                       report::plots_html(plots(planned.plan), a.units) +
                           report::listing_html("Expected deviations", summary(planned)));
  }
  files::print(a.json ? json(planned) : summary(planned),
               a.out == "-" || a.report == "-" ? stderr : stdout);
}

}  // namespace

void add_calibrate_plan_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "calibrate-plan", "Computes currents to run on a bench, so that identify learns the most.");
  auto a = std::make_shared<PlanArguments>();
  command->add_option("WIRE", a->wire, "nearest preset, or file that ends in .toml")->required();
  command
      ->add_option("--set", a->settings,
                   "key=value of the wire, such as wire.length_mm=120; repeatable")
      ->allow_extra_args(false);
  command->add_option("--load-N", a->loads_N, "loads A,B,... in N; default: the best three")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--stress-MPa", a->stresses_MPa, "the same as stresses in MPa")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->excludes("--load-N");
  command->add_option("--duration-s", a->duration_s, "duration of each run, s")
      ->capture_default_str();
  command->add_option("--out", a->out, "CSV file of the currents; - is standard output")
      ->capture_default_str();
  add_report_options(*command, a->report, a->units);
  command->add_flag("--json", a->json, "print the numbers as JSON");
  command->add_option("--threads", a->threads, "default: all cores")->check(CLI::Range(1, 1024));
  command->callback([a] { run(*a); });
}

}  // namespace smaservo::plan
