#include "host-sim/can/outcome.hpp"

#include <array>
#include <chrono>
#include <ctime>
#include <fmt/format.h>

#include "firmware/parameters/parameters.hpp"
#include "firmware/text/device_names.hpp"
#include "host-sim/can/shown.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::can {
namespace {

constexpr std::int64_t boot_patience_us = 3'000'000;

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
  return fmt::format("until {} s after the last command (`can hold` keeps it)",
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
  return fmt::format("at {} after {:.2f} s (target {})\n",
                     position_text(remote.number("6064"), units), took_s,
                     position_text(target_um, units));
}

std::string stored_text() {
  return fmt::format("stored: {} parameters and the settings of the bus, for the next start\n",
                     parameter_count);
}

std::string faults_reset_text(Remote& remote, FaultSet before) {
  const auto state = remote.whole("device.state");
  return fmt::format(
      "{}; the wire's state is {}, current off\n",
      before.empty() ? "no fault was latched" : "acknowledged: " + text::names_of(before),
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
            ? fmt::format("{}: stays {}", name, now)
            : fmt::format("{}: {} -> {}", name, text::value_text(object, before[i]), now));
    text += '\n';
  }
  return text;
}

std::string restored_text(const std::vector<Difference>& differences, Units units) {
  std::vector<Change> changes;
  std::vector<Bytes> before;
  for (const Difference& difference : differences) {
    const text::KnownObject object = text::find_object(std::string(difference.row->path.text()));
    const Kind kind = object.unit.suffix.empty() ? Kind() : object.kind;
    const auto [here, there] =
        std::pair(bytes_of(object, difference.here), bytes_of(object, difference.there));
    changes.emplace_back(kind.empty() ? object : text::in_unit(object, unit_in(kind, units)), here);
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
  return changed_text(changes, before) +
         fmt::format("on trial for {} s, until {}: `can keep` keeps it, `can revert` ends it\n",
                     seconds, clock_text(seconds));
}

std::string keep_trial(Remote& remote) {
  const double left_s = trial_left_s(remote, "keep");
  remote.keep_trial();
  return fmt::format("kept, {:.1f} s before the trial's end; `can store` keeps it over a reset\n",
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
  return fmt::format("stop sent: node {} answers NMT alone, until `can start` or `can reset`\n",
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
  return fmt::format("reset sent: node {} has not reported its start within {} s\n", remote.node(),
                     boot_patience_us / 1'000'000);
}

}  // namespace smaservo::can
