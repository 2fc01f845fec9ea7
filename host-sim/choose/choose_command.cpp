#include "host-sim/choose/choose_command.hpp"

#include <memory>
#include <nlohmann/json.hpp>

#include "host-sim/choose/choose.hpp"
#include "host-sim/choose/output.hpp"
#include "host-sim/report/html.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/text_table.hpp"
#include "model/units.hpp"

namespace smaservo::choose {
namespace {

struct ChooseArguments {
  std::optional<double> force_N, stroke_mm, length_mm, supply_V;
  double time_s = 1, ambient_degC = 25, fan_m_s = 2;
  std::vector<double> spring;  ///< preload in N, and rate in N/mm
  bool one_way = false;
  std::string life = "long";
  int parallel = 1;
  bool makers = false, json = false;
  std::string report;
  Units units = Units::bench;
};

Task task_of(const ChooseArguments& a) {
  const auto needed = [](const std::optional<double>& value, const char* option) {
    if (!value) {
      throw CLI::RequiredError(option);
    }
    return *value;
  };
  Task task{.force_N = needed(a.force_N, "--force-N"),
            .stroke_m = 1e-3 * needed(a.stroke_mm, "--stroke-mm"),
            .time_s = a.time_s,
            .length_m = {},
            .spring = {},
            .one_way = a.one_way,
            .supply_V = a.supply_V,
            .ambient_K = a.ambient_degC + zero_degC_K,
            .fan_m_s = a.fan_m_s,
            .life = life_of(a.life),
            .parallel = a.parallel};
  if (a.length_mm) {
    task.length_m = 1e-3 * *a.length_mm;
  }
  if (!a.spring.empty()) {
    task.spring = Spring{a.spring[0], 1e3 * a.spring[1]};
  }
  return task;
}

void run(const ChooseArguments& a) {
  if (a.makers) {
    const std::vector<MakersCheck> checks = check_makers();
    files::print(a.json ? files::json_text(json(checks)) : text(checks));
    return;
  }
  const Task task = task_of(a);
  const Choice choice = choose_wires(task);
  if (!a.report.empty()) {
    report::write_html(
        a.report, "choose",
        (choice.suitable.empty() ? "" : report::plots_html(panels(task, choice), a.units)) +
            report::listing_html("Wires", text(task, choice)));
  }
  files::print(a.json ? files::json_text(json(choice)) : text(task, choice),
               a.report == "-" ? stderr : stdout);
  if (choice.suitable.empty()) {
    throw files::NoResult("no wire of the makers' tables does it; the reasons are above");
  }
}

}  // namespace

void add_choose_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "choose", "Says which wires of the makers' tables move a load, with which current.");
  auto a = std::make_shared<ChooseArguments>();
  command->add_option("--force-N", a->force_N, "force against which the wire contracts, N");
  command->add_option("--stroke-mm", a->stroke_mm, "by how much it contracts, mm");
  command->add_option("--time-s", a->time_s, "time in which it contracts, s")
      ->capture_default_str();
  command->add_option("--length-mm", a->length_mm,
                      "length of the wire, mm; default: as the stroke needs");
  command->add_flag("--one-way", a->one_way,
                    "the force acts only while the wire contracts; default: it is a weight");
  command->add_option("--spring", a->spring, "a bias spring: N on the cold wire, N/mm")
      ->type_name("PRELOAD,RATE")
      ->delimiter(',')
      ->expected(2)
      ->allow_extra_args(false);
  command->add_option("--supply-V", a->supply_V, "voltage of the supply, V");
  command->add_option("--ambient-degC", a->ambient_degC, "temperature of the air, degC")
      ->capture_default_str();
  command->add_option("--fan-m-s", a->fan_m_s, "speed of the air from a fan, m/s")
      ->capture_default_str();
  command
      ->add_option("--life", a->life,
                   "long: the makers' suggested force and stroke; short: their maximum")
      ->check(CLI::IsMember({"long", "short"}))
      ->capture_default_str();
  command->add_option("--parallel", a->parallel, "at most so many wires side by side")
      ->capture_default_str();
  add_report_options(*command, a->report, a->units);
  command
      ->add_flag("--makers", a->makers,
                 "the makers' currents and times beside the model's, and nothing else")
      ->excludes("--force-N")
      ->excludes("--stroke-mm")
      ->excludes("--report");
  command->add_flag("--json", a->json, "print the numbers as JSON");
  command->callback([a] { run(*a); });
}

}  // namespace smaservo::choose
