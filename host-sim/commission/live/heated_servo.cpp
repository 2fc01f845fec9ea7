#include "host-sim/commission/live/heated_servo.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <fmt/format.h>
#include <functional>

#include "firmware/command.hpp"
#include "firmware/text/device_names.hpp"
#include "firmware/text/fault_reference.hpp"
#include "host-sim/can/settings.hpp"
#include "host-sim/can/status.hpp"
#include "model/files/error.hpp"

namespace smaservo::commission {
namespace {

constexpr unsigned operation_mask = 0x6F, operation_enabled = 0x27;
constexpr unsigned fault_mask = 0x08;
constexpr unsigned enable_word = 0x0F;
constexpr int power_mode = -2;

/// Longer than a client such as `hold` or the page waits between two commands.
constexpr double listen_s = 1.2;
/// A device that goes on heating for longer than this without commands is not begun with.
constexpr double most_timeout_s = 10;
constexpr double start_patience_s = 3;
constexpr std::int64_t check_us = 500'000;
constexpr std::int64_t start_poll_us = 10'000;

std::string fault_text(Fault fault) {
  if (fault == Fault::none) {
    return "no fault is named";
  }
  const FaultRow& row = fault_row(fault);
  return fmt::format("{}: {} Check: {}", row.name, row.text, row.check);
}

/// The first of a set, in words, with the names of all.
std::string faults_text_of(FaultSet set) {
  Fault first = Fault::none;
  for_each_fault(set, [&](Fault fault) { first = first == Fault::none ? fault : first; });
  const std::string all = text::names_of(set);
  return all == fault_name(first) ? fault_text(first)
                                  : fmt::format("{}; {}", all, fault_text(first));
}

FaultSet faults_named(can::Remote& remote, const std::string& name) {
  return FaultSet::from_bits(remote.whole("faults." + name + "_low") |
                             static_cast<std::uint64_t>(remote.whole("faults." + name + "_high"))
                                 << 32U);
}

/// What the device has latched first; for a fault of the axis alone, what its error code stands
/// for.
Fault cause_of_end(can::Remote& remote) {
  // A command source that has gone: no heartbeat or command, no RPDO, no SYNC.
  constexpr std::array<std::uint32_t, 3> source_gone{0x8130, 0x8250, 0x8100};
  const Fault first = can::first_cause(remote);
  if (first != Fault::none) {
    return first;
  }
  const std::uint32_t code = remote.whole("603F");
  return std::ranges::find(source_gone, code) != source_gone.end()
             ? Fault::bus_lost
             : text::find_fault(fmt::format("{:04X}h", code));
}

/// Does it, and once more if that fails: an answer is lost, or whoever else uses the bus interrupts
/// what ends a run. What went wrong at last; empty: nothing.
std::string tried_again(const std::function<void()>& act) {
  std::string wrong;
  for (int i = 0; i < 2; ++i) {
    try {
      act();
      return "";
    } catch (const std::exception& error) {
      wrong = error.what();
    }
  }
  return wrong;
}

void pass_time(can::Bus& bus, std::int64_t until_us) {
  hal::CanFrame passing;
  while (bus.receive(passing, until_us)) {
  }
}

}  // namespace

void HeatedServo::require_free() {
  const unsigned node = remote_.node();
  const auto status = remote_.whole("6041");
  if ((status & fault_mask) != 0) {
    throw files::UserError(
        fmt::format("node {} has a fault: {} `host-sim can --node {} reset-faults` acknowledges it",
                    node, fault_text(cause_of_end(remote_)), node));
  }
  const std::string state = can::drive_state_text(status);
  if (state == "Operation enabled" || state == "Quick stop active") {
    throw files::UserError(
        fmt::format("node {} is in \"{}\" already: somebody commands it; end that, then `host-sim "
                    "can --node {} "
                    "disable`",
                    node, state, node));
  }
  if (state != "Switch on disabled" && state != "Ready to switch on" && state != "Switched on") {
    throw files::UserError(
        fmt::format("node {} is in \"{}\": it cannot be enabled now", node, state));
  }
  require_no_other_master();
  device_ = std::make_unique<const Prepared<double>>(prepare(can::read_settings(remote_)));
  timeout_s_ = remote_.number("2002:1");
  if (!(timeout_s_ <= most_timeout_s)) {
    throw files::UserError(fmt::format(
        "node {}: command_source.timeout_s is {} s: must be at most {} s, since it ends the heat "
        "where this program or the bus is lost",
        node, timeout_s_, most_timeout_s));
  }
  listen_for_others();
  // By now the device has had time to look at its readings.
  ambient_K_ = remote_.number("live.estimated_ambient_K");
  const std::string load = judge_load(*device_, stress_Pa());
  if (!load.empty()) {
    throw files::UserError(fmt::format("node {}: {}", node, load));
  }
  const FaultSet blocks = faults_named(remote_, "blocks");
  if (!blocks.empty()) {
    throw files::UserError(
        fmt::format("node {} cannot be enabled: {}", node, faults_text_of(blocks)));
  }
}

/// What is watched in the place of this program's commands: then the device's time-out would be
/// that of another master.
void HeatedServo::require_no_other_master() {
  const auto watches = [&](const std::string& object) {
    return remote_.whole(object) % (1U << 16U) != 0;
  };
  for (const char* const object : {"1016:1", "1016:2", "1016:3", "1016:4"}) {
    if (watches(object)) {
      throw files::UserError(
          fmt::format("node {} obeys another master: it watches that master's heartbeat ({}h)",
                      remote_.node(), object));
    }
  }
  for (const char* const object : {"1400:5", "1401:5", "1402:5", "1403:5"}) {
    if (watches(object)) {
      throw files::UserError(
          fmt::format("node {} obeys another master: it watches that master's RPDOs ({}h)",
                      remote_.node(), object));
    }
  }
}

void HeatedServo::listen_for_others() {
  constexpr std::uint32_t not_valid = 0x8000'0000;
  constexpr std::uint32_t id_mask = 0x7FF;
  std::array<std::uint32_t, 4> rpdos{};
  for (std::size_t i = 0; i < rpdos.size(); ++i) {
    const auto cob = remote_.whole(fmt::format("{:04X}:1", 0x1400 + i));
    rpdos.at(i) = (cob & not_valid) != 0 ? 0 : cob & id_mask;
  }
  can::Bus& bus = remote_.bus();
  const std::int64_t until_us = bus.now_us() + static_cast<std::int64_t>(listen_s * 1e6);
  hal::CanFrame frame;
  while (bus.receive(frame, until_us)) {
    if (frame.extended || frame.remote) {
      continue;
    }
    // A client writes: the download of CiA 301 begins with command 1, a block of it with 6.
    const unsigned command = frame.data[0] >> 5U;
    const bool writes =
        frame.id == 0x600 + remote_.node() && frame.length == 8 && (command == 1 || command == 6);
    const bool is_rpdo = frame.id != 0 && std::ranges::find(rpdos, frame.id) != rpdos.end();
    if (writes || is_rpdo) {
      throw files::UserError(fmt::format(
          "node {} is commanded by somebody else: {} came within {} s; end that program first",
          remote_.node(), writes ? "a write by SDO" : "an RPDO", listen_s));
    }
  }
}

void HeatedServo::begin() {
  can::Remote& remote = remote_;
  if ((remote.whole("6041") & operation_mask) == operation_enabled) {
    throw files::UserError(
        fmt::format("node {} has been enabled by somebody else meanwhile", remote.node()));
  }
  mode_ = remote.text("6060");
  power_text_ = remote.text("target.power_W");
  begun_ = true;
  power_W_ = 0;
  remote.set("target.power_W", "0");
  remote.set("6060", std::to_string(power_mode));
  // Read only if the wire does not pass the device's own check.
  record({{"current_A", "voltage_V"}, 1, 0, ""});
  try {
    remote.enable();
    remote.set_mode(power_mode);
    wait_until_running();
  } catch (const files::UserError&) {
    const auto status = remote.whole("6041");
    if ((status & fault_mask) == 0 && can::first_cause(remote) == Fault::none) {
      throw;
    }
    explain_end(status);
  }
}

void HeatedServo::wait_until_running() {
  can::Bus& bus = remote_.bus();
  const auto running = static_cast<std::uint32_t>(DeviceState::running);
  const std::int64_t until_us = bus.now_us() + static_cast<std::int64_t>(start_patience_s * 1e6);
  while (remote_.whole("device.state") != running) {
    const auto status = remote_.whole("6041");
    if ((status & operation_mask) != operation_enabled || bus.now_us() >= until_us) {
      explain_end(status);
    }
    remote_.renew();
    pass_time(bus, bus.now_us() + start_poll_us);
  }
}

void HeatedServo::record(const can::RecordingPlan& plan) {
  can::arm_recorder(remote_, plan);
  recording_ = plan;
}

std::string HeatedServo::recorded_resistance() {
  const can::Recording rows = can::read_recording(remote_, recording_);
  const double least_A = least_current_share * device_->settings.limits.min_current_A;
  Means sums{0, 0, stress_Pa()};
  for (const std::vector<double>& row : rows.rows) {
    if (row[0] >= least_A && std::isfinite(row[1])) {
      sums.current_A += row[0];
      sums.voltage_V += row[1];
    }
  }
  return sums.current_A > 0 ? judge_cold(*device_, sums, ambient_K()) : "";
}

/// A wire that is not that of the settings can look like anything to the device, even like one that
/// is too hot; so the resistance of the cold wire is judged first.
void HeatedServo::explain_end(unsigned status) {
  Fault first = cause_of_end(remote_);
  if (first == Fault::none) {
    for_each_fault(faults_named(remote_, "blocks"),
                   [&](Fault fault) { first = first == Fault::none ? fault : first; });
  }
  const std::string resistance = is_cold_ ? recorded_resistance() : "";
  if (!resistance.empty()) {
    throw files::UserError(fmt::format("node {}: {}; the servo has ended the heat by itself: {}",
                                       remote_.node(), resistance, fault_name(first)));
  }
  throw files::UserError(fmt::format("node {} has ended the heat (\"{}\"): {}", remote_.node(),
                                     can::drive_state_text(status), fault_text(first)));
}

void HeatedServo::set_power(double power_W, bool heats) {
  is_cold_ = is_cold_ && !heats;
  remote_.set("target.power_W", fmt::format("{}", static_cast<float>(power_W)));
  power_W_ = static_cast<double>(static_cast<float>(power_W));
}

/// Others who command show in what they have written.
void HeatedServo::require_own_command() {
  const bool is_own = remote_.whole("6040") == enable_word &&
                      std::lround(remote_.number("6060")) == power_mode &&
                      std::abs(remote_.number("target.power_W") - power_W_) <= 1e-6 * power_W_;
  if (!is_own) {
    throw files::UserError(fmt::format(
        "node {} is commanded by somebody else: its controlword, mode or set-point has changed",
        remote_.node()));
  }
}

Means HeatedServo::look() {
  const auto status = remote_.whole("6041");
  if ((status & operation_mask) != operation_enabled) {
    // Somebody who has disabled it shows by the controlword, and not as a fault.
    if ((status & fault_mask) == 0) {
      require_own_command();
    }
    explain_end(status);
  }
  const std::int64_t now_us = remote_.bus().now_us();
  if (now_us - checked_us_ >= check_us) {
    checked_us_ = now_us;
    require_own_command();
    remote_.renew();
  }
  return {remote_.number("live.current_A"), remote_.number("live.voltage_V"), stress_Pa()};
}

std::string HeatedServo::limited_by() {
  return text::limit_reason_names(remote_.whole("device.limit_reasons"));
}

std::string HeatedServo::put_back() noexcept {
  if (!begun_) {
    return "; nothing was heated";
  }
  begun_ = false;
  const std::string hot = tried_again([&] { remote_.disable(); });
  if (!hot.empty()) {
    return fmt::format(
        "; the heat could not be switched off from here ({}): the servo ends it by itself {} s "
        "after the last command",
        hot, timeout_s_);
  }
  const std::string other = tried_again([&] {
    remote_.set("target.power_W", power_text_);
    remote_.set("6060", mode_);
  });
  if (!other.empty()) {
    return fmt::format("; the heat is off; mode and set-point are not as before: {}", other);
  }
  return "; the heat is off";
}

}  // namespace smaservo::commission
