#include "host-sim/page/servos/operations.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "firmware/canopen/node/index.hpp"
#include "firmware/canopen/node/object.hpp"
#include "firmware/canopen/servo/servo_core.hpp"
#include "firmware/text/canopen/change_text.hpp"
#include "firmware/text/canopen/objects.hpp"
#include "firmware/text/settings_file.hpp"
#include "firmware/text/settings_text.hpp"
#include "host-sim/can/settings.hpp"
#include "host-sim/can/step_test.hpp"
#include "host-sim/page/servos/messages/tables.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::page {
namespace {

namespace index = canopen::index;

using files::UserError;
using nlohmann::json;

constexpr Key watch_key{0x2002, 1};
constexpr Key tuning_command_key{0x2102, 1};
constexpr double longest_step_s = 600;

std::uint32_t whole(can::Remote& remote, Key key) {
  return static_cast<std::uint32_t>(canopen::take_number(remote.client().upload(key)));
}

/// Whether the change makes the parameters differ from what 1010h has stored.
bool is_unsaved(const canopen::LoggedChange& change) {
  return change.result == canopen::Abort::none && change.before != change.value &&
         change.key.index >= 0x2000 && change.key != watch_key && change.key != tuning_command_key;
}

/// Whether the change ended a transaction by restoring the old values.
bool is_reverted(const canopen::LoggedChange& change) {
  constexpr std::uint32_t by_time = 0, by_command = 4;
  return change.key == tuning_command_key && change.result == canopen::Abort::none &&
         (change.value == by_time || change.value == by_command);
}

}  // namespace

Operations::Operations(SharedBus& bus, LiveTraffic& traffic, Control& control,
                       const OperationsPlan& plan)
    : bus_(bus), traffic_(traffic), control_(control), plan_(plan) {}

Servo& Operations::servo(unsigned node) {
  const auto found = traffic_.servos().find(node);
  if (found == traffic_.servos().end()) {
    std::vector<unsigned> nodes;
    for (const auto& [number, servo] : traffic_.servos()) {
      nodes.push_back(number);
    }
    throw UserError(
        fmt::format("node {}: no such servo on {}; there are: {}", node, bus_.name(),
                    nodes.empty() ? "none" : fmt::format("{}", fmt::join(nodes, ", "))));
  }
  Servo& servo = found->second;
  if (servo.duplicate) {
    throw UserError(fmt::format(
        "node {}: two devices answer under this node-id, so neither is commanded; take one off the "
        "bus, and give it another by identity.node_id or LSS",
        node));
  }
  if (!servo.online) {
    throw UserError(fmt::format("{}: does not answer; is it supplied, and is the bus connected?",
                                servo.title()));
  }
  return servo;
}

can::Remote Operations::remote(unsigned node) {
  can::SdoClient client(bus_, node);
  client.set_timeout(static_cast<std::int64_t>(plan_.timeout_s * 1e6));
  return can::Remote(client);
}

// What kind of device a node is.

namespace {

/// Whether the device is a servo; a device of another kind may not have this object.
bool is_servo(can::Remote& remote) {
  try {
    return whole(remote, {index::identity, 2}) == canopen::servo_product;
  } catch (const can::SdoError& error) {
    if (error.code() == 0) {
      throw;
    }
    return false;
  }
}

}  // namespace

bool Operations::join(Servo& servo) {
  can::Remote remote = this->remote(servo);
  if (!is_servo(remote)) {
    return false;
  }
  servo.name = remote.text("1008");
  if (plan_.key) {
    remote.set("access.key", std::to_string(*plan_.key));
  }
  read_pdo(servo, remote);
  servo.usual_timeout_s.reset();
  servo.unsaved = false;
  servo.changes_seen.reset();
  read_parameters(servo);
  read_changes(servo);
  servo.joined = true;
  traffic_.refresh(servo.node);
  return true;
}

/// Reads whether RPDO1 has its default mapping: a renewal then needs no SDO request, which would
/// have to wait for the end of a long transfer.
void Operations::read_pdo(Servo& servo, can::Remote& remote) {
  servo.commanded = {};
  servo.commanded.by_pdo =
      whole(remote, {index::rpdo_communication, 1}) == 0x200U + servo.node &&
      whole(remote, {index::rpdo_communication, 2}) >= 254 &&
      whole(remote, {index::rpdo_mapping, 0}) == 2 &&
      whole(remote, {index::rpdo_mapping, 1}) == canopen::mapped(index::controlword, 0, 16) &&
      whole(remote, {index::rpdo_mapping, 2}) == canopen::mapped(index::mode, 0, 8);
}

std::vector<std::size_t> Operations::read_parameters(Servo& servo) {
  std::vector<std::size_t> rows(parameter_count);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i] = i;
  }
  return read_parameters(servo, rows);
}

std::vector<std::size_t> Operations::read_parameters(Servo& servo,
                                                     const std::vector<std::size_t>& rows) {
  can::Remote remote = this->remote(servo);
  // If one request is not answered, no value is stored, so that each change is reported exactly
  // once.
  std::vector<std::uint32_t> values;
  values.reserve(rows.size());
  for (const std::size_t row : rows) {
    values.push_back(whole(remote, parameters<double>[row].key));
  }
  std::vector<std::size_t> changed;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (servo.parameters->put(rows[i], {values[i]})) {
      changed.push_back(rows[i]);
    }
  }
  return changed;
}

std::vector<std::size_t> Operations::read_changes(Servo& servo) {
  constexpr std::size_t size = canopen::ChangeLog::bytes;
  can::Remote remote = this->remote(servo);
  const std::uint32_t count = whole(remote, {0x2220, 1});
  const std::uint32_t seen = servo.changes_seen.value_or(0);
  const bool first = !servo.changes_seen;
  if (count == seen) {
    servo.changes_seen = count;
    return {};
  }
  const can::Bytes log = remote.read(text::find_object("changes.last"));
  const std::size_t kept = log.size() / size;
  const std::size_t fresh = count - seen;
  bool all = fresh > kept && !first;
  servo.unsaved = servo.unsaved || fresh > kept;
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < std::min(fresh, kept); ++i) {
    const canopen::LoggedChange change = text::change_of(std::span(log).subspan(i * size, size));
    servo.unsaved = servo.unsaved || is_unsaved(change);
    all = all || (is_reverted(change) && !first);
    const std::size_t row = find_parameter(change.key);
    if (row != no_parameter && change.result == canopen::Abort::none) {
      rows.push_back(row);
    }
  }
  std::vector<std::size_t> changed;
  if (!first) {
    changed = all ? read_parameters(servo) : read_parameters(servo, rows);
  }
  // The count is stored after everything has been read: if reading fails, the next round repeats
  // it.
  servo.changes_seen = count;
  return changed;
}

void Operations::skip_changes(Servo& servo) {
  can::Remote remote = this->remote(servo);
  servo.changes_seen = whole(remote, {0x2220, 1});
}

// Motion.

void Operations::shorten_watch(Servo& servo) {
  if (servo.usual_timeout_s) {
    return;
  }
  can::Remote remote = this->remote(servo);
  const float usual_s = canopen::as_real(whole(remote, watch_key));
  if (usual_s <= plan_.watch_s) {
    return;
  }
  try {
    remote.set("command_source.timeout_s", fmt::format("{}", plan_.watch_s));
    servo.usual_timeout_s = usual_s;
  } catch (const can::SdoError& error) {
    if (error.code() == 0) {
      throw;
    }
  }
}

void Operations::put_back_watch(Servo& servo) {
  if (!servo.usual_timeout_s) {
    return;
  }
  remote(servo).set("command_source.timeout_s", fmt::format("{}", *servo.usual_timeout_s));
  servo.usual_timeout_s.reset();
}

void Operations::enable(Servo& servo, Control::Ticket ticket) {
  can::Remote remote = this->remote(servo);
  shorten_watch(servo);
  if (!control_.heat(ticket, servo.node)) {
    throw UserError("control has passed on");
  }
  remote.enable();
  // The values that are renewed from now on.
  servo.commanded.word = static_cast<std::uint16_t>(remote.number("6040"));
  servo.commanded.mode = static_cast<std::int8_t>(remote.number("6060"));
  servo.enabled_us = bus_.now_us();
  traffic_.refresh(servo.node);
}

void Operations::disable(Servo& servo) {
  can::Remote remote = this->remote(servo);
  remote.disable();
  servo.enabled_us = 0;
  control_.cooled(servo.node);
  put_back_watch(servo);
  traffic_.refresh(servo.node);
}

void Operations::reset_faults(Servo& servo) {
  remote(servo).reset_faults();
  servo.freeze_frame.reset();
  traffic_.refresh(servo.node);
}

void Operations::set_mode(Servo& servo, int mode) {
  const auto& rows = mode_rows();
  if (mode != 0 && std::ranges::find(rows, mode, &ModeRow::mode) == rows.end()) {
    std::vector<std::string> names;
    names.reserve(rows.size());
    for (const ModeRow& row : rows) {
      names.push_back(fmt::format("{} ({})", row.mode, row.name));
    }
    throw UserError(fmt::format("mode = {}: must be one of {}", mode, fmt::join(names, ", ")));
  }
  remote(servo).set_mode(mode);
  traffic_.refresh(servo.node);
}

void Operations::set_position(Servo& servo, double value) {
  can::Remote remote = this->remote(servo);
  const auto target_um = static_cast<std::int32_t>(std::lround(value));
  if (remote.number("6061") != 1) {
    remote.set("607A", std::to_string(target_um));
  } else if ((static_cast<unsigned>(remote.number("6041")) & 0x6FU) != 0x27) {
    throw UserError(fmt::format(
        "{}: is not enabled: in Profile position a target is a move, which begins at once",
        servo.title()));
  } else {
    remote.start_move(target_um);
  }
}

void Operations::set_target(Servo& servo, double value) {
  can::Remote remote = this->remote(servo);
  const int mode = static_cast<int>(remote.number("6061"));
  const auto within = [&](double low, double high, const char* unit) {
    if (!(low <= value && value <= high)) {
      throw UserError(fmt::format("target = {}: must be {} to {}{}", value, low, high, unit));
    }
  };
  switch (mode) {
    case 1:
    case 8:
      within(-2147483648.0, 2147483647.0, " um");
      set_position(servo, value);
      break;
    case 4:
    case 10:
      within(-32768, 32767, " in 0.1 % of the rated force");
      remote.set("6071", fmt::format("{}", std::lround(value)));
      break;
    case 6:
      // Homing begins with bit 4: the present position becomes the home position.
      remote.set("6040", "15");
      remote.set("6040", "31");
      remote.set("6040", "15");
      break;
    case -1:
    case -2:
    case -3:
      remote.set(fmt::format("2201:{}", -mode), fmt::format("{}", value));
      break;
    default:
      throw UserError(
          fmt::format("{}: mode {} has no target; set a mode first", servo.title(), mode));
  }
  traffic_.refresh(servo.node);
}

// Measuring.

Operations::Step Operations::step(Servo& servo, Control::Ticket ticket, std::int32_t amplitude_um,
                                  double seconds) {
  can::Remote remote = this->remote(servo);
  const bool was_enabled = control_.heated()[servo.node] &&
                           (static_cast<unsigned>(remote.number("6041")) & 0x6FU) == 0x27;
  if (!was_enabled) {
    enable(servo, ticket);
  }
  const can::StepRun run = can::run_step(remote, {amplitude_um, std::min(seconds, longest_step_s)});
  if (!was_enabled) {
    disable(servo);
  }
  const can::StepResult result = can::judge(run);
  Step answer{run.recording, json::object(), json::object()};
  const auto number = [](double value) { return json_number(static_cast<float>(value)); };
  answer.figures = {{"rise_s", number(result.figures.rise_s)},
                    {"settling_s", number(result.figures.settling_s)},
                    {"overshoot_percent", number(result.figures.overshoot_percent)},
                    {"error_percent", number(result.figures.error_percent)},
                    {"peak_K", number(result.peak_K)}};
  for (std::size_t row = 0; row < parameter_count; ++row) {
    const std::string_view path = parameters<double>[row].path.text();
    const std::optional<Value> value = servo.parameters->get(row);
    if (!can::shapes_step(path) || !value) {
      continue;
    }
    answer.gains[std::string(path)] = json::parse(parameter_json(parameters<double>[row], *value));
  }
  return answer;
}

RunningRecording::RunningRecording(can::Remote remote, can::RecordingPlan plan, double patience_s)
    : remote_(remote), plan_(std::move(plan)) {
  can::arm_recorder(remote_, plan_);
  watch_.emplace(remote_, plan_, patience_s);
}

can::RecorderStage RunningRecording::look() {
  // NOLINTNEXTLINE(bugprone-unchecked-optional-access): watch_ is set by the constructor
  stage_ = watch_->look();
  return stage_;
}

}  // namespace smaservo::page
