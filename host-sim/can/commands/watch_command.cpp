#include <fmt/format.h>
#include <memory>
#include <unistd.h>

#include "hal/recording/trace_file.hpp"
#include "host-sim/can/bus/recorder.hpp"
#include "host-sim/can/commands/session.hpp"
#include "host-sim/can/watch.hpp"
#include "model/files/message.hpp"

namespace smaservo::can {
namespace {

void record(const Common& common, Remote& remote, const can::RecordingPlan& plan,
            const std::string& out, double patience_s) {
  can::arm_recorder(remote, plan);
  const auto waits = [&] {
    if (!plan.trigger.empty()) {
      say(common, [&] { return fmt::format("waiting for {}", files::printable(plan.trigger)); });
    }
  };
  can::wait_for_recorder(remote, plan, patience_s, waits);
  hal::TraceFile file(
      out,
      {"host-sim can record", fmt::format("node {} on {}", remote.node(), remote.bus().name())},
      std::vector(1 + plan.signals.size(), hal::mcap::Kind::number));
  const can::Recording recording = can::read_recording(remote, plan);
  file.write(can::to_csv(recording));
  file.commit();
  can::require_complete(recording, plan, out);
}

}  // namespace

void add_watch_commands(CLI::App& can, const std::shared_ptr<Common>& common) {
  auto plan = std::make_shared<can::WatchPlan>();
  auto once = std::make_shared<bool>(false);
  CLI::App* watch =
      add(can, "watch", "Shows live values; on a terminal as a table that is redrawn.", [=] {
        if (*once) {
          plan->count = 1;
        }
        plan->units = common->units;
        Session session(*common);
        const bool in_place = plan->count == 0 && isatty(STDOUT_FILENO) != 0;
        can::watch(
            session.remote(), *plan, in_place,
            [=](const std::string& text) {
              if (in_place) {
                files::clear_terminal();
              }
              print(text);
            },
            [=](const std::string& line) { say(*common, [&] { return line; }); });
      });
  watch->add_option(
      "NAME", plan->names,
      "objects, as for `get`; without a unit in that of --units; default: a selection");
  watch->add_option("--period", plan->period_s, "time between rows, s")
      ->capture_default_str()
      ->check(seconds_of(0.01, 3600));
  watch->add_option("--count", plan->count, "number of rows; default: for ever");
  watch->add_flag("--once", *once, "prints one row and ends");
  watch->add_option("--plot", plan->plot, "draws the curve of this object as text");

  auto record_plan = std::make_shared<can::RecordingPlan>();
  auto out = std::make_shared<std::string>();
  auto patience_s = std::make_shared<double>(60);
  record_plan->signals = {"position_m", "setpoint", "wire_temperature_K", "drive_current_A",
                          "resistance_ohm"};
  CLI::App* record_command =
      add(can, "record", "Records signals at the rate of the loop into a CSV or MCAP file.", [=] {
        Session session(*common);
        record(*common, session.remote(), *record_plan, *out, *patience_s);
      });
  record_command
      ->add_option(
          "--signals", record_plan->signals,
          "up to 8 live values: SI names, such as wire_temperature_K, with or without `live.`")
      ->delimiter(',');
  record_command->add_option("--seconds", record_plan->seconds, "duration, s")
      ->capture_default_str()
      ->check(seconds_of(0.001, 86400));
  record_command
      ->add_option("--before", record_plan->before_s,
                   "part of the duration that lies before the trigger, s")
      ->check(seconds_of(0, 86400));
  record_command->add_option("--trigger", record_plan->trigger,
                             "SIGNAL>LEVEL or SIGNAL<LEVEL, in SI");
  record_command->add_option("--patience", *patience_s, "longest wait for the trigger, s")
      ->capture_default_str()
      ->check(seconds_of(0, 1e6));
  record_command
      ->add_option("--out", *out,
                   "CSV file, or MCAP if the name ends in .mcap; - is standard output")
      ->required();
}

}  // namespace smaservo::can
