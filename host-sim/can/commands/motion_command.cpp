#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <memory>

#include "host-sim/can/commands/session.hpp"
#include "host-sim/can/outcome.hpp"
#include "host-sim/can/positions.hpp"
#include "host-sim/can/status.hpp"
#include "host-sim/can/step_test.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::can {
namespace {

struct StepArguments {
  can::StepPlan plan;
  std::string runs = "can-steps";
  std::string report;
  unsigned overlay = 4;
};

/// The files of earlier runs, the newest first.
std::vector<std::filesystem::path> earlier_runs(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("step-") && name.ends_with(".csv")) {
      files.push_back(entry.path());
    }
  }
  std::ranges::sort(files, std::ranges::greater());
  return files;
}

void step(Remote& remote, const StepArguments& a, Units units) {
  files::prepare_folder("--runs", a.runs);
  const auto before = earlier_runs(a.runs);
  // Earlier runs are read before anything moves, so that an unreadable file stops the test early.
  std::vector<can::StepRun> runs;
  for (std::size_t i = 0; i < std::min<std::size_t>(before.size(), a.overlay); ++i) {
    runs.push_back(can::load_step(before[i].string()));
  }
  const auto gains = can::read_gains(remote);
  runs.insert(runs.begin(), can::run_step(remote, a.plan));
  runs.front().gains = gains;
  const unsigned number =
      before.empty() ? 1
                     : 1 + static_cast<unsigned>(std::strtoul(
                               before.front().stem().string().substr(5).c_str(), nullptr, 10));
  std::vector<std::string> names{fmt::format("step-{:04}", number)};
  files::OutputFile file((std::filesystem::path(a.runs) / (names[0] + ".csv")).string());
  file.write(can::step_csv(runs[0]));
  file.commit();
  for (std::size_t i = 0; i + 1 < runs.size(); ++i) {
    names.push_back(before[i].stem().string());
  }
  print(can::step_text(runs, names, units));
  if (!a.report.empty()) {
    can::write_step_report(a.report, runs, names, units);
  }
}

}  // namespace

void add_motion_commands(CLI::App& can, const std::shared_ptr<Common>& common) {
  add_plain(can, common, "start",
            "NMT: makes the node operational, so that it exchanges process data.",
            [](Remote& remote, const Common& c) {
              remote.nmt(can::NmtCommand::start);
              std::string said = can::started_text(remote);
              say(c, [&] { return said; });
            });
  add_plain(can, common, "stop",
            "NMT: stops the node's communication except NMT and heartbeat; heat ends (6007h).",
            [](Remote& remote, const Common& c) {
              remote.nmt(can::NmtCommand::stop);
              say(c, [&] { return can::stopped_text(remote); });
            });
  add_plain(can, common, "reset", "NMT: restarts the node, and waits for its start; heat ends.",
            [](Remote& remote, const Common& c) {
              remote.nmt(can::NmtCommand::reset_node);
              std::string said = can::restarted_text(remote);
              say(c, [&] { return said; });
            });
  add_plain(can, common, "enable",
            "Enables the drive through the states of CiA 402; it may then heat the wire.",
            [](Remote& remote, const Common& c) {
              remote.enable();
              say(c, [&] { return can::enabled_text(remote); });
            });
  add_plain(can, common, "disable", "Disables the drive: current off, the wire relaxes.",
            [](Remote& remote, const Common& c) {
              remote.disable();
              say(c, [&] { return can::disabled_text(remote, c.units); });
            });
  add_plain(can, common, "reset-faults", "Acknowledges faults; disables the drive.",
            [](Remote& remote, const Common& c) {
              const FaultSet before = c.quiet ? FaultSet() : can::latched_faults(remote);
              remote.reset_faults();
              say(c, [&] { return can::faults_reset_text(remote, before); });
            });
  auto hold_s = std::make_shared<double>(1e6);
  CLI::App* hold =
      add(can, "hold", "Keeps an enabled drive enabled, as a master that is there does.",
          [common, hold_s] {
            Session session(*common);
            session.remote().hold(*hold_s);
          });
  hold->footer(
      "Who types commands by hand leaves it running in a second terminal: get and watch, set and\n"
      "try of parameters are no commands and do not renew heat.");
  hold->add_option("--for", *hold_s, "duration, s; default: 1000000 s, 11 days")
      ->check(seconds_of(0, 1e6));
  auto target = std::make_shared<std::string>();
  auto patience_s = std::make_shared<double>(10);
  CLI::App* move = add(
      can, "move", "Moves to a position (Profile position) and waits until it is reached.", [=] {
        const std::int32_t target_um = can::position_um(*target, common->units);
        Session session(*common);
        can::require_allowed(session.remote(), target_um, *target, common->units);
        const std::int64_t start_us = session.bus().now_us();
        session.remote().move(target_um, *patience_s);
        const double took_s = static_cast<double>(session.bus().now_us() - start_us) * 1e-6;
        say(*common,
            [&] { return can::moved_text(session.remote(), target_um, took_s, common->units); });
      });
  move->add_option("POSITION", *target,
                   "contraction: 0.8mm, or in um alone: 1000; with --units si always with a unit")
      ->required();
  move->add_option("--patience", *patience_s, "longest wait, s")
      ->capture_default_str()
      ->check(seconds_of(0, 1e6));

  auto a = std::make_shared<StepArguments>();
  CLI::App* step_command =
      add(can, "step",
          "Makes a step there and back; prints its figures beside those of earlier runs.", [=] {
            Session session(*common);
            step(session.remote(), *a, common->units);
          });
  step_command
      ->add_option("--amplitude-um", a->plan.amplitude_um, "size of the step, um of contraction")
      ->capture_default_str();
  step_command
      ->add_option("--seconds", a->plan.seconds,
                   "duration of the step there, and of the step back, s")
      ->capture_default_str()
      ->check(seconds_of(0.2, 600));
  step_command->add_option("--runs", a->runs, "folder that keeps the runs")->capture_default_str();
  step_command
      ->add_option("--overlay", a->overlay, "number of earlier steps to compare the new one with")
      ->capture_default_str();
  step_command->add_option("--report", a->report, "HTML page with pictures");
}

}  // namespace smaservo::can
