#include "host-sim/can/outcome.hpp"

#include <array>
#include <chrono>
#include <ctime>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include "firmware/command.hpp"
#include "firmware/parameters/parameters.hpp"
#include "firmware/text/device_names.hpp"
#include "host-sim/can/positions.hpp"
#include "host-sim/can/shown.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::can {
namespace {

constexpr std::int64_t boot_patience_us = 3'000'000;
constexpr std::int64_t settling_us = 1'000'000;
constexpr std::int64_t settling_poll_us = 10'000;

/// How long an enabled drive may be heated: while what 1016h or the event timers of RPDOs watch is
/// there, if they watch anything; else for a time after the last command.
std::string heat_lasts_text(Remote& remote) {
  const auto watches = [&](const char* object) { return remote.whole(object) % (1U << 16U) != 0; };
  for (const char* const heartbeat : {"1016:1", "1016:2", "1016:3", "1016:4"}) {
    if (watches(heartbeat)) {
      return "while the watched heartbeats (1016h) come";
    }
  }
  for (const char* const timer : {"1400:5", "1401:5", "1402:5", "1403:5"}) {
    if (watches(timer)) {
      return fmt::format("while the RPDO of {}h comes", std::string(timer, 4));
    }
  }
  return fmt::format(
      "until {} s after the last enable, move or set-point (`host-sim can hold` keeps it)",
      remote.text("command_source.timeout_s"));
}

std::string clock_text(double from_now_s) {
  const std::time_t at = std::chrono::system_clock::to_time_t(
      std::chrono::system_clock::now() +
      std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * from_now_s)));
  std::tm local{};
  localtime_r(&at, &local);
  std::array<char, 16> text{};
  std::strftime(text.data(), text.size(), "%H:%M:%S", &local);
  return text.data();
}

enum class TuningState : std::uint8_t { none, open, on_trial };

TuningState tuning_state(Remote& remote) {
  return static_cast<TuningState>(remote.whole("tuning.state"));
}

/// The time that is left of a trial. Throws if there is none, as after one that has ended by
/// itself.
double trial_left_s(Remote& remote, const char* verb) {
  if (tuning_state(remote) != TuningState::on_trial) {
    throw files::UserError(
        fmt::format("node {} has no trial to {}: `host-sim can try` begins one; it may have ended "
                    "by itself",
                    remote.node(), verb));
  }
  return remote.number("tuning.remaining_s");
}

/// Whether a statusword says "Switch on disabled", the state without current and without a fault.
bool is_disabled(std::uint32_t statusword) {
  return (statusword & 0x4FU) == 0x40;
}

/// Statusword and state of the device after a command that switches the heat off; waits until they
/// say so, at most for settling_us.
std::pair<std::uint32_t, std::uint32_t> settled(Remote& remote) {
  const std::int64_t until_us = remote.bus().now_us() + settling_us;
  for (;;) {
    const std::uint32_t drive = remote.whole("6041");
    const std::uint32_t state = remote.whole("device.state");
    const bool is_heated_still =
        state < device_state_count && is_heated(static_cast<DeviceState>(state));
    const std::int64_t now_us = remote.bus().now_us();
    if ((is_disabled(drive) && !is_heated_still) || until_us <= now_us) {
      return {drive, state};
    }
    hal::CanFrame passing;
    while (remote.bus().receive(passing, now_us + settling_poll_us)) {
    }
  }
}

}  // namespace

std::string enabled_text(Remote& remote) {
  return fmt::format("enabled: may be heated {}\n", heat_lasts_text(remote));
}

std::string disabled_text(Remote& remote, Units units) {
  return fmt::format(
      "disabled: current off, the wire relaxes from {}, {}\n",
      position_text(remote.number("6064"), units),
      quantity_text(remote.number("live.wire_temperature_K"), kind::temperature, units));
}

std::string moved_text(Remote& remote, std::int32_t target_um, double took_s, Units units) {
  const std::string at = position_text(remote.number("6064"), units);
  const std::uint32_t window_um = remote.whole("6067");
  const std::string target = position_text(target_um, units);
  return window_um == std::numeric_limits<std::uint32_t>::max()  // any position counts as reached
             ? fmt::format("at {} after {:.2f} s (target {})\n", at, took_s, target)
             : fmt::format("within {} of {} after {:.2f} s: at {}\n",
                           position_text(window_um, units), target, took_s, at);
}

std::string stored_text() {
  return fmt::format("stored: {} parameters and the settings of the bus, for the next start\n",
                     parameter_count);
}

std::string faults_reset_text(Remote& remote, FaultSet before) {
  const auto [drive, state] = settled(remote);
  return fmt::format(
      "{}; the drive is {}, the wire's state is {}\n",
      before.empty() ? "there was no fault to acknowledge"
                     : "acknowledged: " + text::names_of(before),
      is_disabled(drive) ? "disabled" : fmt::format("in \"{}\"", drive_state_text(drive)),
      state < device_state_count ? text::state_name(static_cast<DeviceState>(state)) : "unknown");
}

std::vector<Bytes> values_before(Remote& remote, const std::vector<Change>& changes) {
  std::vector<Bytes> before;
  for (const auto& [object, value] : changes) {
    try {
      before.push_back(remote.read(object));
    } catch (const SdoError& error) {
      if (error.code() == 0) {
        throw;
      }
      before.emplace_back();
    }
  }
  return before;
}

std::string changed_text(const std::vector<Change>& changes, const std::vector<Bytes>& before) {
  std::string text;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const auto& [object, value] = changes[i];
    const std::string now = text::value_text(object, value);
    const std::string name = object.name.empty() ? text::title(object) : object.name;
    text += files::printable(
        before[i].empty() ? fmt::format("{}: {}", name, now)
        : before[i] == value
            ? fmt::format("{}: was {} already", name, now)
            : fmt::format("{}: {} -> {}", name, text::value_text(object, before[i]), now));
    text += '\n';
  }
  return text;
}

std::string restored_text(const std::vector<Difference>& differences, Units units) {
  std::vector<Change> changes;
  std::vector<Bytes> before;
  for (const Difference& difference : differences) {
    const text::KnownObject object = parameter_in(std::string(difference.row->path.text()), units);
    const auto [here, there] =
        std::pair(bytes_of(object, difference.here), bytes_of(object, difference.there));
    changes.emplace_back(object, here);
    before.push_back(there);
  }
  return changed_text(changes, before);
}

std::string begin_trial(Remote& remote, const std::vector<Change>& changes, double seconds) {
  for (const auto& [object, value] : changes) {
    if (object.parameter == nullptr) {
      throw files::UserError(fmt::format(
          "{}: is no parameter, so the node cannot take it back; `host-sim can set` writes it",
          text::title(object)));
    }
    if (object.parameter->change != smaservo::Change::live) {
      throw files::UserError(
          fmt::format("{}: cannot be tried, since it changes only without current; `host-sim can "
                      "set` writes it",
                      text::title(object)));
    }
  }
  switch (tuning_state(remote)) {
    case TuningState::none:
      break;
    case TuningState::open:
      throw files::UserError(fmt::format(
          "node {}: somebody else is writing a set of changes; try again when it is done",
          remote.node()));
    default:
      throw files::UserError(
          fmt::format("node {} has a trial already, for {:.1f} s more: `host-sim can keep` or "
                      "`host-sim can revert` ends it",
                      remote.node(), remote.number("tuning.remaining_s")));
  }
  const std::vector<Bytes> before = values_before(remote, changes);
  remote.try_for(changes, seconds, Remote::Client::leaves);
  return changed_text(changes, before) + fmt::format(
                                             "on trial for {} s, until {}: `host-sim can keep` "
                                             "makes it stay, `host-sim can revert` "
                                             "ends it\n",
                                             seconds, clock_text(seconds));
}

std::string keep_trial(Remote& remote) {
  const double left_s = trial_left_s(remote, "keep");
  remote.keep_trial();
  return fmt::format(
      "kept, {:.1f} s before the trial's end; `host-sim can store` saves it for the next "
      "start\n",
      left_s);
}

std::string revert_trial(Remote& remote) {
  const double left_s = trial_left_s(remote, "revert");
  remote.revert_trial();
  return fmt::format("reverted, {:.1f} s before the trial's end: as it was before `try`\n", left_s);
}

std::string started_text(Remote& remote) {
  return fmt::format("operational: node {} exchanges process data; the drive is in \"{}\"\n",
                     remote.node(), drive_state_text(remote.whole("6041")));
}

std::string stopped_text(Remote& remote) {
  return fmt::format(
      "stop sent to node {}: heat ends, unless 6007h, 605Ah or 605Eh was set to keep it; what the "
      "node did is not known, a stopped node answers NMT alone, until `host-sim can start` or "
      "`host-sim can reset`\n",
      remote.node());
}

std::string restarted_text(Remote& remote) {
  const std::int64_t start_us = remote.bus().now_us();
  hal::CanFrame frame;
  while (remote.bus().receive(frame, start_us + boot_patience_us)) {
    if (frame.id == 0x700 + remote.node() && frame.length == 1 && frame.data[0] == 0) {
      return fmt::format("reset: node {} has started anew after {:.2f} s; current off\n",
                         remote.node(),
                         static_cast<double>(remote.bus().now_us() - start_us) * 1e-6);
    }
  }
  throw files::UserError(
      fmt::format("reset sent: node {} on {} has not reported its start within {} s", remote.node(),
                  remote.bus().name(), boot_patience_us / 1'000'000));
}

}  // namespace smaservo::can
