#include "firmware/daemon/status/status.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "firmware/safety/standing.hpp"
#include "firmware/text/device_names.hpp"
#include "model/files/message.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::daemon {
namespace {

using Json = nlohmann::ordered_json;

double us(std::int64_t ns) {
  return static_cast<double>(ns) / 1e3;
}

Json json_of(const Histogram& times) {
  return {{"count", times.count()},
          {"mean", times.mean_ns() / 1e3},
          {"p50", us(times.quantile_ns(0.5))},
          {"p99", us(times.quantile_ns(0.99))},
          {"p99_9", us(times.quantile_ns(0.999))},
          {"max", us(times.max_ns())}};
}

Json json_of(FaultSet set) {
  Json names = Json::array();
  for_each_fault(set, [&](Fault fault) { names.push_back(fault_name(fault)); });
  return names;
}

Json stops_json(const LoopFigures& figures) {
  Json stops = Json::object();
  for (std::size_t i = 1; i < fault_count; ++i) {
    const LoopFigures::Stop& stop = figures.stops.at(i);
    if (stop.count.load() > 0) {
      stops[std::string(fault_name(static_cast<Fault>(i)))] = {
          {"count", stop.count.load()}, {"sample_to_off_us_max", us(stop.longest_ns.load())}};
    }
  }
  return stops;
}

Json warning_causes_json(const LoopFigures& figures) {
  Json counts = Json::object();
  for_each_fault(warning_faults, [&](Fault fault) {
    if (const std::uint32_t count = figures.warning_causes.at(warning_index(fault)).load()) {
      counts[std::string(fault_name(fault))] = count;
    }
  });
  return counts;
}

std::string line_of(const char* name, const Histogram& times) {
  return fmt::format("{:<16}{:>10.1f}{:>10.1f}{:>10.1f}{:>10.1f}\n", name,
                     us(times.quantile_ns(0.5)), us(times.quantile_ns(0.99)),
                     us(times.quantile_ns(0.999)), us(times.max_ns()));
}

}  // namespace

std::string status_json(const Status& status) {
  const LoopFigures& f = status.figures;
  const Output<double>& out = status.output;
  Json json{{"version", SMASERVO_VERSION},
            {"board", status.board},
            {"period_us", us(status.period_ns)},
            {"state", text::state_name(out.state)},
            {"mode", text::mode_name(out.mode)},
            {"time_s", static_cast<double>(out.time_us) * 1e-6},
            {"drive_current_A", out.drive_current_A},
            {"strain", out.estimate.strain},
            {"wire_temperature_K", out.estimate.temperature_K},
            {"latched", json_of(out.latched)},
            {"first_cause", fault_name(out.first_cause)},
            {"warnings", json_of(out.warnings)},
            {"warning_causes", warning_causes_json(f)},
            {"blocks", json_of(out.blocks)},
            {"cycles", f.cycles.load()},
            {"missed", f.missed.load()},
            {"no_frame", f.no_frame.load()},
            {"lost_frames", f.lost_frames.load()},
            {"setpoints", f.setpoints.load()},
            {"superseded", f.superseded.load()},
            {"wake_us", json_of(f.wake)},
            {"execution_us", json_of(f.execution)},
            {"sample_to_drive_us", json_of(f.sample_to_drive)},
            {"instructions_per_loop_cycle", nullptr},
            {"page_faults", nullptr},
            {"stops", stops_json(f)},
            {"guard_stops", f.guard_stops.load()},
            {"recording", nullptr},
            {"last_run", nullptr},
            {"machine", status.warnings}};
  if (status.usage.instructions) {
    json["instructions_per_loop_cycle"] = *status.usage.instructions;
  }
  if (status.usage.page_faults) {
    json["page_faults"] = {{"minor", status.usage.page_faults->minor},
                           {"major", status.usage.page_faults->major}};
  }
  if (status.recording) {
    json["recording"] = {{"path", status.recording->path}, {"rows", status.recording->rows}};
    json["recording"]["problem"] = nullptr;
    if (!status.recording->problem.empty()) {
      json["recording"]["problem"] = status.recording->problem;
    }
  }
  if (!status.last_run.empty()) {
    json["last_run"] = status.last_run;
  }
  return files::json_text(json, -1);
}

std::string status_text(const Status& status) {
  const LoopFigures& f = status.figures;
  const Output<double>& out = status.output;
  std::string text = fmt::format(
      "{} cycles of {:.6g} us on {}, {} missed, {} without a frame, {} frames lost\n"
      "state {}, first cause {}, latched: {}\n",
      f.cycles.load(), us(status.period_ns), files::printable(status.board), f.missed.load(),
      f.no_frame.load(), f.lost_frames.load(), text::state_name(out.state),
      fault_name(out.first_cause), out.latched.empty() ? "none" : text::names_of(out.latched));
  text += fmt::format("{:<16}{:>10}{:>10}{:>10}{:>10}\n", "us", "50 %", "99 %", "99.9 %", "max");
  text += line_of("wake-up", f.wake);
  text += line_of("execution", f.execution);
  text += line_of("sample to drive", f.sample_to_drive);
  if (status.usage.instructions) {
    text += fmt::format("{:.0f} instructions per loop cycle\n", *status.usage.instructions);
  }
  if (status.usage.page_faults) {
    text += fmt::format("page faults in the loop: {} minor, {} major\n",
                        status.usage.page_faults->minor, status.usage.page_faults->major);
  }
  for (std::size_t i = 1; i < fault_count; ++i) {
    const LoopFigures::Stop& stop = f.stops.at(i);
    if (stop.count.load() > 0) {
      text += fmt::format("stopped by {}: {} times, off at most {:.1f} us after the sample\n",
                          fault_name(static_cast<Fault>(i)), stop.count.load(),
                          us(stop.longest_ns.load()));
    }
  }
  for_each_fault(warning_faults, [&](Fault fault) {
    if (const std::uint32_t count = f.warning_causes.at(warning_index(fault)).load()) {
      text += fmt::format("warned of {}: its cause has come {} time{}\n", fault_name(fault), count,
                          count == 1 ? "" : "s");
    }
  });
  if (f.setpoints.load() > 0) {
    text +=
        fmt::format("{} cyclic set-points, {} superseded by a newer one before a cycle took them\n",
                    f.setpoints.load(), f.superseded.load());
  }
  if (f.guard_stops.load() > 0) {
    text += fmt::format("the guard switched the outputs off {} times, because the loop hung\n",
                        f.guard_stops.load());
  }
  if (status.recording) {
    text += fmt::format("recorded {} rows in {}{}{}\n", status.recording->rows,
                        files::printable(status.recording->path),
                        status.recording->problem.empty() ? "" : ", until ",
                        files::printable(status.recording->problem));
  }
  return text;
}

}  // namespace smaservo::daemon
