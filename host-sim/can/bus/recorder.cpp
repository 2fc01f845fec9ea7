#include "host-sim/can/bus/recorder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>

#include "firmware/canopen/servo/drive_objects.hpp"
#include "firmware/signals.hpp"
#include "firmware/text/signal_names.hpp"
#include "model/files/error.hpp"

namespace smaservo::can {
namespace {

enum class RecorderState : std::uint8_t { idle, armed, triggered, full };

constexpr std::int64_t poll_us = 20'000;

/// No setting of the recorder heats a wire, and each may be written twice: so a request that
/// collides with one of another client does not end a recording.
void set(Remote& remote, const std::string& name, const auto& value) {
  remote.set(name, fmt::format("{}", value), Remote::Write::again);
}

/// The signal's name without "live.".
std::string signal_name(const std::string& name) {
  return std::string(signal_rows<double>.at(text::signal_row(name)).name);
}

void set_trigger(Remote& remote, const std::string& trigger) {
  const std::size_t sign = trigger.find_first_of("<>");
  if (trigger.empty()) {
    set(remote, "recorder.trigger_signal", 0);
    return;
  }
  if (sign == std::string::npos) {
    throw files::UserError(
        fmt::format("--trigger {}: must be SIGNAL>LEVEL or SIGNAL<LEVEL", trigger));
  }
  set(remote, "recorder.trigger_signal", sub_of(text::signal_row(trigger.substr(0, sign))));
  set(remote, "recorder.trigger_edge", trigger[sign] == '>' ? 0 : 1);
  set(remote, "recorder.trigger_level", trigger.substr(sign + 1));
}

/// The number of whole periods. The device sends its period as a float, which may be slightly more
/// than the intended number.
double rows_within(double time_s, double period_s) {
  return std::floor(time_s / period_s + 1e-3);
}

/// The index of the first row of the requested time. A memory that was not full contains all rows
/// since the recorder was armed; if the trigger's signal was recorded, the trigger is found as the
/// device does, otherwise the result is 0.
std::size_t first_row(const Recording& recording, const RecordingPlan& plan) {
  const std::size_t sign = plan.trigger.find_first_of("<>");
  if (sign == std::string::npos) {
    return 0;
  }
  const std::string signal = signal_name(plan.trigger.substr(0, sign));
  if (std::ranges::find(recording.signals, signal) == recording.signals.end()) {
    return 0;
  }
  const std::vector<double> values = recording.column(signal);
  const double level = std::strtod(plan.trigger.c_str() + sign + 1, nullptr);
  const bool rises = plan.trigger[sign] == '>';
  const auto before = static_cast<std::size_t>(rows_within(plan.before_s, recording.period_s));
  for (std::size_t i = std::max<std::size_t>(before, 1); i < values.size(); ++i) {
    const bool was_below = values[i - 1] < level;
    if (was_below == rises && (values[i] < level) != was_below) {
      return i - before;
    }
  }
  return 0;
}

RecorderState state_of(Remote& remote) {
  return static_cast<RecorderState>(remote.whole("recorder.state"));
}

double period_of(Remote& remote) {
  const double period_s = remote.number("recorder.period_s");
  if (!(period_s >= 1e-6 && period_s <= 1e4)) {
    throw files::UserError(fmt::format(
        "node {}: recorder.period_s is {} s: must be 1e-06 to 10000 s", remote.node(), period_s));
  }
  return period_s;
}

}  // namespace

void arm_recorder(Remote& remote, const RecordingPlan& plan) {
  if (plan.signals.empty() || plan.signals.size() > canopen::channel_count) {
    throw files::UserError(
        fmt::format("{} signals: must be 1 to {}", plan.signals.size(), canopen::channel_count));
  }
  if (plan.before_s > 0 && plan.trigger.empty()) {
    throw files::UserError(fmt::format("--before {} s: needs a --trigger", plan.before_s));
  }
  if (plan.before_s >= plan.seconds) {
    throw files::UserError(fmt::format("--before {} s: must be less than the {} s of the recording",
                                       plan.before_s, plan.seconds));
  }
  set(remote, "recorder.command", 0);
  for (std::size_t i = 0; i < canopen::channel_count; ++i) {
    const unsigned sub = i < plan.signals.size() ? sub_of(text::signal_row(plan.signals[i])) : 0;
    set(remote, fmt::format("recorder.channel_{}", i + 1), sub);
  }
  set_trigger(remote, plan.trigger);
  // The recorder shows its capacity only after it has been armed.
  set(remote, "recorder.divisor", 1);
  set(remote, "recorder.pretrigger", 0);
  try {
    set(remote, "recorder.command", 1);
  } catch (const SdoError& error) {
    throw files::UserError(fmt::format("the device has no memory to record to: {}", error.what()));
  }
  const double step_s = period_of(remote);
  const double capacity = remote.number("recorder.capacity");
  set(remote, "recorder.command", 0);
  const double divisor = std::max(1.0, std::ceil(plan.seconds / (step_s * capacity) - 1e-6));
  if (divisor > 65535) {
    throw files::UserError(fmt::format("{} s: too long, must be at most {} s", plan.seconds,
                                       65535 * step_s * capacity));
  }
  set(remote, "recorder.divisor", divisor);
  set(remote, "recorder.pretrigger", rows_within(plan.before_s, step_s * divisor));
  set(remote, "recorder.command", 1);
}

RecorderWatch::RecorderWatch(Remote& remote, const RecordingPlan& plan, double patience_s)
    : remote_(remote),
      patience_s_(patience_s),
      until_us_(remote.bus().now_us() + static_cast<std::int64_t>(patience_s * 1e6)),
      after_us_(static_cast<std::int64_t>((plan.seconds - plan.before_s) * 1e6)),
      // The recording is complete with this many rows, even if the memory has room for more. A loop
      // that misses cycles takes longer to collect them.
      rows_(std::ceil(plan.seconds / period_of(remote))),
      rows_before_(remote.number("recorder.pretrigger")) {}

RecorderStage RecorderWatch::look() {
  const std::int64_t longest_us = 10 * after_us_ + 5'000'000;
  const RecorderState state = state_of(remote_);
  const std::int64_t now_us = remote_.bus().now_us();
  if (state == RecorderState::full || state == RecorderState::idle) {
    return RecorderStage::complete;
  }
  if (state == RecorderState::triggered && triggered_us_ == 0) {
    triggered_us_ = now_us;
  }
  if (triggered_us_ != 0) {
    const bool is_complete =
        now_us >= triggered_us_ + after_us_ &&
        (remote_.number("recorder.samples") >= rows_ || now_us >= triggered_us_ + longest_us);
    return is_complete ? RecorderStage::complete : RecorderStage::recording;
  }
  if (now_us >= until_us_) {
    set(remote_, "recorder.command", 0);
    throw files::UserError(fmt::format("not triggered within {} s", patience_s_));
  }
  can_trigger_ = can_trigger_ || remote_.number("recorder.samples") >= rows_before_;
  return can_trigger_ ? RecorderStage::waiting : RecorderStage::filling;
}

void wait_for_recorder(Remote& remote, const RecordingPlan& plan, double patience_s,
                       const std::function<void()>& waits) {
  Bus& bus = remote.bus();
  RecorderWatch watch(remote, plan, patience_s);
  bool has_waited = false;
  for (RecorderStage stage = watch.look(); stage != RecorderStage::complete; stage = watch.look()) {
    if (stage == RecorderStage::waiting && !has_waited) {
      has_waited = true;
      waits();
    }
    const std::int64_t next_us = bus.now_us() + poll_us;
    hal::CanFrame passing;
    while (bus.receive(passing, next_us)) {
    }
  }
}

Recording read_recording(Remote& remote, const RecordingPlan& plan) {
  Recording recording{{}, period_of(remote), {}};
  std::ranges::transform(plan.signals, std::back_inserter(recording.signals), signal_name);
  set(remote, "recorder.command", 0);
  const Bytes bytes = remote.client().upload_block(text::find_object("recorder.data").key);
  const std::size_t width = 4 * plan.signals.size();
  std::span<const std::uint8_t> rest(bytes);
  for (; rest.size() >= width; rest = rest.subspan(width)) {
    std::vector<double> row;
    for (std::size_t i = 0; i < width; i += 4) {
      const auto bits = static_cast<std::uint32_t>(canopen::take_number(rest.subspan(i, 4)));
      row.push_back(static_cast<double>(canopen::as_real(bits)));
    }
    recording.rows.push_back(std::move(row));
  }
  // Drops the rows between the end of the requested time and the stop, and those before the
  // requested time.
  const auto max = static_cast<std::size_t>(std::ceil(plan.seconds / recording.period_s));
  const std::size_t first = first_row(recording, plan);
  auto& rows = recording.rows;
  rows.erase(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(first));
  const bool has_begin = plan.trigger.empty() || first != 0;
  if (has_begin && rows.size() > max) {
    rows.resize(max);
  }
  return recording;
}

void require_complete(const Recording& recording, const RecordingPlan& plan,
                      const std::string& file) {
  const double has_s = static_cast<double>(recording.rows.size()) * recording.period_s;
  if (has_s < 0.98 * plan.seconds - recording.period_s) {
    throw files::NoResult(fmt::format(
        "{}: the recording has ended after {:.4g} of {:.4g} s: the device was reset, or somebody "
        "else has stopped it",
        file, has_s, plan.seconds));
  }
}

}  // namespace smaservo::can
