#include "host-sim/can/step_test.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "firmware/command.hpp"
#include "firmware/parameters/parameters.hpp"
#include "host-sim/can/shown.hpp"
#include "host-sim/report/html.hpp"
#include "host-sim/report/text_plot.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/text_table.hpp"
#include "model/units.hpp"

namespace smaservo::can {
namespace {

constexpr double before_s = 0.1;
constexpr std::int64_t step_poll_us = 20'000;

enum class StepState : std::uint8_t { none, running, done, broken_off };

bool is_enabled(Remote& remote) {
  return (remote.whole("6041") & 0x6FU) == 0x27;
}

void wait_until_done(Remote& remote, const StepPlan& plan) {
  Bus& bus = remote.bus();
  const double patience_s = 2 * plan.seconds + 5;
  const std::int64_t until_us = bus.now_us() + static_cast<std::int64_t>(patience_s * 1e6);
  for (;;) {
    const auto state = static_cast<StepState>(remote.whole("step.state"));
    if (state == StepState::done) {
      return;
    }
    if (state == StepState::broken_off || state == StepState::none) {
      throw files::UserError(
          fmt::format("the step was broken off: \"{}\"; `host-sim can faults` says more",
                      drive_state_text(remote.whole("6041"))));
    }
    remote.renew();
    const std::int64_t now_us = bus.now_us();
    if (now_us >= until_us) {
      throw files::UserError(fmt::format("the step has not ended within {} s", patience_s));
    }
    hal::CanFrame passing;
    while (bus.receive(passing, now_us + step_poll_us)) {
    }
  }
}

/// Waits until the wire is at rest, because the figures of a step are computed from there.
void wait_until_still(Remote& remote) {
  constexpr double patience_s = 5;
  constexpr double still_um_s = 100;
  Bus& bus = remote.bus();
  const std::int64_t until_us = bus.now_us() + static_cast<std::int64_t>(patience_s * 1e6);
  const auto running = static_cast<double>(DeviceState::running);
  while (remote.number("device.state") != running || std::abs(remote.number("606C")) > still_um_s) {
    remote.renew();
    const std::int64_t now_us = bus.now_us();
    if (now_us >= until_us) {
      throw files::UserError(
          fmt::format("the wire has not come to a rest within {} s", patience_s));
    }
    hal::CanFrame passing;
    while (bus.receive(passing, now_us + step_poll_us)) {
    }
  }
}

/// Waits until the recording has begun, which must be before the step: the step is found where the
/// set-point leaves its first value.
void wait_until_recording(Remote& remote) {
  constexpr double patience_s = 5;
  Bus& bus = remote.bus();
  const std::int64_t until_us = bus.now_us() + static_cast<std::int64_t>(patience_s * 1e6);
  while (remote.number("recorder.samples") == 0) {
    remote.renew();
    if (bus.now_us() >= until_us) {
      throw files::UserError(fmt::format("the recorder has not begun within {} s", patience_s));
    }
    hal::CanFrame passing;
    while (bus.receive(passing, bus.now_us() + 1000)) {
    }
  }
}

/// Enables the drive; the destructor disables it if it was disabled before.
class EnabledForAWhile {
 public:
  explicit EnabledForAWhile(Remote& remote) : remote_(remote), was_enabled_(is_enabled(remote)) {
    if (!was_enabled_) {
      remote_.enable();
    }
  }
  ~EnabledForAWhile() {
    try {
      if (!was_enabled_) {
        remote_.disable();
      }
    } catch (const std::exception& error) {
      files::complain("host-sim", error.what());
    }
  }
  EnabledForAWhile(const EnabledForAWhile&) = delete;
  EnabledForAWhile& operator=(const EnabledForAWhile&) = delete;

 private:
  Remote& remote_;
  bool was_enabled_;
};

/// The rows at which the set-point leaves its first value, and at which it returns.
struct Edges {
  std::size_t there, back;
};
Edges edges_of(const std::vector<double>& setpoints, double amplitude_m) {
  const auto moved = [&](double value) {
    return std::abs(value - setpoints.front()) > std::abs(amplitude_m) / 10;
  };
  const auto there = std::ranges::find_if(setpoints, moved);
  const auto back = std::find_if_not(there, setpoints.end(), moved);
  return {static_cast<std::size_t>(there - setpoints.begin()),
          static_cast<std::size_t>(back - setpoints.begin())};
}

/// The signed distance of the set-point from its first value, at the row where it is greatest.
double amplitude_of(const std::vector<double>& setpoints) {
  double amplitude = 0;
  for (const double value : setpoints) {
    const double way = value - setpoints.front();
    if (std::abs(way) > std::abs(amplitude)) {
      amplitude = way;
    }
  }
  return amplitude;
}

/// Columns: time since the step, contraction and set-point relative to their first values,
/// temperature, current.
struct StepColumns {
  report::Column time_s, way_um, setpoint_um, temperature_degC, current_mA;
};
StepColumns columns_of(const StepRun& run) {
  const auto setpoints = run.recording.column("setpoint");
  const auto positions = run.recording.column("position_m");
  const Edges edges = edges_of(setpoints, amplitude_of(setpoints));
  std::vector<double> time_s(positions.size());
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    time_s[i] =
        (static_cast<double>(i) - static_cast<double>(edges.there)) * run.recording.period_s;
  }
  const auto um = [](const std::vector<double>& metres) {
    return report::column_of(metres, [&](double m) { return 1e6 * (m - metres.front()); });
  };
  return {
      report::column(std::move(time_s)), um(positions), um(setpoints),
      report::column_of(run.recording.column("wire_temperature_K"),
                        [](double K) { return K - zero_degC_K; }),
      report::column_of(run.recording.column("drive_current_A"), [](double A) { return 1e3 * A; })};
}

/// The time axis of a text plot; 0 is the time at which the set-point leaves its first value.
struct TimeAxis {
  double from_s, to_s;
  std::size_t columns = 64;
};
TimeAxis axis_of(const StepRun& run) {
  const auto setpoints = run.recording.column("setpoint");
  const Edges edges = edges_of(setpoints, amplitude_of(setpoints));
  const double from_s = -static_cast<double>(edges.there) * run.recording.period_s;
  return {from_s, from_s + static_cast<double>(setpoints.size()) * run.recording.period_s};
}

/// The contraction relative to its first value, averaged over each column of a text plot; NaN for
/// columns without rows.
std::vector<double> way(const StepRun& run, const TimeAxis& axis, const Unit& unit) {
  const auto positions = run.recording.column("position_m");
  const double first_s = axis_of(run).from_s;
  std::vector<double> sums(axis.columns, 0);
  std::vector<double> counts(axis.columns, 0);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double time_s = first_s + static_cast<double>(i) * run.recording.period_s;
    const double column = std::floor((time_s - axis.from_s) / (axis.to_s - axis.from_s) *
                                     static_cast<double>(axis.columns));
    if (column >= 0 && column < static_cast<double>(axis.columns)) {
      sums[static_cast<std::size_t>(column)] += unit.from_si(positions[i] - positions.front());
      ++counts[static_cast<std::size_t>(column)];
    }
  }
  for (std::size_t k = 0; k < sums.size(); ++k) {
    sums[k] /= counts[k];
  }
  return sums;
}

files::TextTable figures_of(const std::vector<StepRun>& runs, const std::vector<std::string>& names,
                            Units units) {
  const Unit degree = unit_in(kind::temperature, units);
  files::TextTable table({{""},
                          {"rise s", "{:.3f}"},
                          {"overshoot %", "{:.1f}"},
                          {"settled s", "{:.3f}"},
                          {"error %", "{:.2f}"},
                          {fmt::format("peak {}", degree.suffix), "{:.1f}"}});
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const auto [f, peak_K] = judge(runs[i]);
    table.add({names[i], f.rise_s, f.overshoot_percent, f.settling_s, f.error_percent,
               degree.from_si(peak_K)});
  }
  return table;
}

constexpr std::size_t terminal_width = 80;

/// "strain      proportional_W 0, integral_1_s 0, ...": the values of each group, in lines that a
/// terminal holds.
std::string wrapped_gains(const std::map<std::string, std::string>& gains) {
  constexpr std::size_t indent = 12;
  std::string text;
  std::string line;
  std::string group;
  for (const auto& [path, value] : gains) {
    const std::size_t dot = std::min(path.find('.'), path.size() - 1);
    const std::string part = fmt::format(" {} {}", path.substr(dot + 1), value);
    const bool new_group = path.substr(0, dot) != group;
    if (new_group || line.size() + part.size() + 1 > terminal_width) {
      text += line.empty() ? "" : line + (new_group ? "\n" : ",\n");
      group = path.substr(0, dot);
      line = fmt::format("{:<{}}", new_group ? group : "", indent - 1);
    } else {
      line += ',';
    }
    line += part;
  }
  return files::printable_lines(text + line) + "\n";
}

/// Values that a file has in SI, with their names, in the chosen units. What this version does not
/// know stays as the file has it.
std::map<std::string, std::string> in_units(const std::map<std::string, std::string>& gains,
                                            Units units) {
  std::map<std::string, std::string> shown;
  for (const auto& [path, value] : gains) {
    try {
      const text::KnownObject object = parameter_in(path, units);
      shown[object.name] =
          text::value_text(object, text::value_bytes(text::find_object(path), value));
    } catch (const files::UserError&) {
      shown[path] = value;
    }
  }
  return shown;
}

/// Which runs have no gains in their file, which gains differ, which are the same in all others.
std::string gains_text(const std::vector<StepRun>& runs, const std::vector<std::string>& names,
                       Units units) {
  std::string without;
  std::vector<files::TextTable::Column> columns{{"gains and limits that differ"}};
  std::vector<std::map<std::string, std::string>> known;
  std::map<std::string, std::string> all;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (runs[i].gains.empty()) {
      without += fmt::format("{}: gains not recorded\n", files::printable(names[i]));
      continue;
    }
    columns.push_back({names[i]});
    known.push_back(in_units(runs[i].gains, units));
    all.insert(known.back().begin(), known.back().end());
  }
  files::TextTable differing(columns);
  std::map<std::string, std::string> same;
  for (const auto& [path, value] : all) {
    files::TextTable::Row cells{path};
    bool differs = false;
    for (const auto& gains : known) {
      const auto found = gains.find(path);
      cells.emplace_back(found == gains.end() ? "" : found->second);
      differs = differs || found == gains.end() || found->second != value;
    }
    if (differs) {
      differing.add(cells);
    } else {
      same[path] = value;
    }
  }
  std::string text = same.size() == all.size() ? "" : "\n" + differing.text();
  if (!same.empty()) {
    text += fmt::format("\n{}\n{}", known.size() > 1 ? "the same in all:" : "gains and limits:",
                        wrapped_gains(same));
  }
  return text + (without.empty() ? "" : "\n" + without);
}

}  // namespace

StepRun run_step(Remote& remote, const StepPlan& plan) {
  if (plan.amplitude_um == 0) {
    throw files::UserError("--amplitude-um 0: must not be 0");
  }
  // The recorder's memory is full at the end of the step back or soon after.
  const RecordingPlan recorded{{"setpoint", "position_m", "wire_temperature_K", "drive_current_A"},
                               2 * plan.seconds + before_s,
                               0,
                               ""};
  remote.set("step.amplitude_um", std::to_string(plan.amplitude_um));
  remote.set("step.duration_ms", std::to_string(std::lround(1e3 * plan.seconds)));
  {
    const EnabledForAWhile enabled(remote);
    remote.set_profile_position();
    wait_until_still(remote);
    arm_recorder(remote, recorded);
    wait_until_recording(remote);
    remote.set("step.command", "1");
    wait_until_done(remote, plan);
  }
  return {plan, read_recording(remote, recorded)};
}

StepResult judge(const StepRun& run) {
  const auto setpoints = run.recording.column("setpoint");
  const auto positions = run.recording.column("position_m");
  const auto temperatures = run.recording.column("wire_temperature_K");
  const double amplitude_m = setpoints.empty() ? 0 : amplitude_of(setpoints);
  const Edges edges = setpoints.empty() ? Edges{} : edges_of(setpoints, amplitude_m);
  report::StepJudge judge(std::abs(amplitude_m), run.recording.period_s);
  for (std::size_t i = edges.there; i < edges.back; ++i) {
    judge.add(static_cast<double>(i) * run.recording.period_s, setpoints.front() + amplitude_m,
              positions[i]);
  }
  judge.finish();
  if (amplitude_m == 0 || judge.steps().empty()) {
    throw files::UserError("the recording has no step of 0.2 s and more");
  }
  return {judge.steps().front(), std::ranges::max(temperatures)};
}

bool shapes_step(std::string_view path) {
  constexpr std::array<std::string_view, 4> groups{"strain.", "trajectory.", "drive.", "limits."};
  return std::ranges::any_of(groups,
                             [&](std::string_view group) { return path.starts_with(group); });
}

std::map<std::string, std::string> read_gains(Remote& remote) {
  std::map<std::string, std::string> gains;
  for (const Parameter<double>& row : parameters<double>) {
    const std::string path(row.path.text());
    if (shapes_step(path)) {
      gains[path] = remote.text(path);
    }
  }
  return gains;
}

constexpr std::string_view between = " = ";

std::string step_csv(const StepRun& run) {
  Recording recording = run.recording;
  recording.comments.clear();
  for (const auto& [path, value] : run.gains) {
    recording.comments.push_back(fmt::format("{}{}{}", path, between, value));
  }
  return to_csv(recording);
}

StepRun load_step(const std::string& path) {
  StepRun run{{}, load_recording(path)};
  const auto setpoints = run.recording.column("setpoint");
  if (setpoints.empty()) {
    throw files::UserError(fmt::format("{}: has no rows", path));
  }
  run.plan.amplitude_um = static_cast<std::int32_t>(std::lround(1e6 * amplitude_of(setpoints)));
  for (const std::string& comment : run.recording.comments) {
    const std::size_t at = comment.find(between);
    if (at != std::string::npos && shapes_step(comment.substr(0, at))) {
      run.gains[comment.substr(0, at)] = comment.substr(at + between.size());
    }
  }
  return run;
}

std::string step_text(const std::vector<StepRun>& runs, const std::vector<std::string>& names,
                      Units units) {
  const TimeAxis axis = axis_of(runs.front());
  const Unit length = unit_in(kind::length, units);
  std::vector<std::vector<double>> ways;
  ways.reserve(runs.size());
  for (const StepRun& run : runs) {
    ways.push_back(way(run, axis, length));
  }
  return figures_of(runs, names, units).text() +
         fmt::format("\ncontraction, {}: * {}{}\n", length.suffix, files::printable(names[0]),
                     runs.size() > 1 ? ", . before" : "") +
         report::text_plot(ways, axis.columns, 12) +
         fmt::format("{:12}{:<{}}{:>10.3g} s\n", "", fmt::format("{:.3g} s", axis.from_s),
                     axis.columns - 12, axis.to_s) +
         gains_text(runs, names, units);
}

void write_step_report(const std::string& path, const std::vector<StepRun>& runs,
                       const std::vector<std::string>& names, Units units) {
  const auto panel = [](const char* title, const char* caption, bool half, const char* label) {
    return report::Panel{.title = title,
                         .caption = caption,
                         .half_width = half,
                         .height = half ? 300 : 380,
                         .x = {.label = "time in s"},
                         .y = {.label = label},
                         .link = "time"};
  };
  std::vector<report::Panel> panels{
      panel("Contraction", "The newest run in blue, earlier ones in grey.", false,
            "contraction in µm"),
      panel("Temperature", "As the device estimates it.", true, "temperature in °C"),
      panel("Current", "As the device gives it.", true, "current in mA")};
  for (std::size_t i = runs.size(); i-- > 0;) {
    const StepColumns c = columns_of(runs[i]);
    const char* colour = i == 0 ? "estimate" : "measured";
    if (i == 0) {
      panels[0].series.push_back(
          {.name = "set-point", .colour = "reference", .x = c.time_s, .y = c.setpoint_um});
    }
    const report::Column values[] = {c.way_um, c.temperature_degC, c.current_mA};
    for (std::size_t k = 0; k < panels.size(); ++k) {
      panels[k].series.push_back(
          {.name = names[i], .colour = colour, .x = c.time_s, .y = values[k]});
    }
  }
  report::write_html(path, "Step test",
                     report::plots_html(panels, units) +
                         report::listing_html("Figures", step_text(runs, names, units)));
}

}  // namespace smaservo::can
