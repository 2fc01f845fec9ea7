#include "host-sim/page/servos/servo.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "firmware/canopen/node/index.hpp"
#include "firmware/canopen/node/object.hpp"
#include "firmware/canopen/servo/drive_objects.hpp"
#include "firmware/safety/standing.hpp"
#include "firmware/text/device_names.hpp"
#include "host-sim/can/remote.hpp"
#include "host-sim/page/servos/messages/tables.hpp"

namespace smaservo::page {
namespace {

namespace index = canopen::index;

using nlohmann::json;

constexpr unsigned reached_bit_of_status = 0x400;
constexpr unsigned remote_bit_of_status = 0x200;

/// The names of PROTOCOL.md, in the order of the patterns of the statusword.
const char* drive_name(unsigned statusword) {
  struct State {
    unsigned bits, mask;
    const char* name;
  };
  static constexpr State states[] = {{0x00, 0x4F, "not_ready"},
                                     {0x40, 0x4F, "switch_on_disabled"},
                                     {0x21, 0x6F, "ready"},
                                     {0x23, 0x6F, "switched_on"},
                                     {0x27, 0x6F, "operation_enabled"},
                                     {0x07, 0x6F, "quick_stop"},
                                     {0x0F, 0x4F, "fault_reaction"},
                                     {0x08, 0x4F, "fault"}};
  const auto* const found =
      std::ranges::find_if(states, [&](const State& s) { return (statusword & s.mask) == s.bits; });
  return found == std::end(states) ? "not_ready" : found->name;
}

FaultSet fault_set_at(const Servo& servo, std::uint8_t sub) {
  return FaultSet::from_bits(
      static_cast<std::uint64_t>(servo.value({0x2202, sub})) |
      static_cast<std::uint64_t>(servo.value({0x2202, static_cast<std::uint8_t>(sub + 1)})) << 32U);
}

json fault_names(FaultSet set) {
  json names = json::array();
  for_each_fault(set, [&](Fault fault) { names.push_back(fault_name(fault)); });
  return names;
}

/// How often the cause of each warning that stands has come; of those that the servo counts.
json warning_causes(const Servo& servo) {
  json counts = json::object();
  for_each_fault(fault_set_at(servo, 5) & warning_faults, [&](Fault fault) {
    if (const unsigned count = servo.value(canopen::warning_count_key(fault))) {
      counts[std::string(fault_name(fault))] = count;
    }
  });
  return counts;
}

json limit_names_of(std::uint32_t bits) {
  json names = json::array();
  for (unsigned i = 0; i < static_cast<unsigned>(LimitReason::count); ++i) {
    if ((bits >> i & 1U) != 0) {
      names.push_back(text::limit_reason_name(LimitReason(i)));
    }
  }
  return names;
}

std::string nmt_of(const Servo& servo) {
  if (!servo.online) {
    return servo.heartbeat_state ? can::nmt_state_text(*servo.heartbeat_state) : "";
  }
  return (servo.statusword() & remote_bit_of_status) != 0 ? "operational" : "pre-operational";
}

json target_of(const Servo& servo) {
  switch (servo.mode()) {
    case 1:
    case 8:
      return servo.signed_value({index::target_position, 0});
    case 4:
    case 10:
      return static_cast<std::int16_t>(servo.value({index::target_torque, 0}));
    case -1:
    case -2:
    case -3:
      return json_number(
          canopen::as_real(servo.value({0x2201, static_cast<std::uint8_t>(-servo.mode())})));
    default:
      return nullptr;
  }
}

json frame_of(const std::optional<Sample>& sample) {
  if (!sample) {
    return nullptr;
  }
  json values = json::object();
  for (std::size_t i = 0; i < signal_count; ++i) {
    if (sample->has[i]) {
      values[std::string(signal_rows<float>[i].name)] = json_number(sample->values[i]);
    }
  }
  return values;
}

json transaction_of(const Servo& servo) {
  const unsigned state = servo.value({0x2102, 2});
  return {{"state", state == 2   ? "trying"
                    : state == 1 ? "open"
                                 : "none"},
          {"seconds_left",
           state == 2 ? json_number(canopen::as_real(servo.value({0x2102, 5}))) : json(nullptr)}};
}

}  // namespace

const std::vector<StateObject>& state_objects() {
  static const std::vector<StateObject> all = [] {
    std::vector<StateObject> objects{{{index::statusword, 0}, true},
                                     {{index::mode_display, 0}, false},
                                     {{index::position_actual, 0}, false},
                                     {{index::target_position, 0}, false},
                                     {{index::target_torque, 0}, false},
                                     {{index::quick_stop_option, 0}, false},
                                     {{index::fault_option, 0}, false},
                                     {{0x2102, 2}, false},
                                     {{0x2102, 5}, false},
                                     {{0x2220, 1}, false}};
    for (std::uint8_t sub = 1; sub <= 11; ++sub) {
      objects.push_back({{0x2202, sub}, false});
    }
    for_each_fault(warning_faults, [&](Fault fault) {
      objects.push_back({canopen::warning_count_key(fault), false});
    });
    // Servos of every release answer to these: the round ends with an answer.
    for (std::uint8_t sub = 1; sub <= 3; ++sub) {
      objects.push_back({{0x2201, sub}, false});
    }
    return objects;
  }();
  return all;
}

bool is_idle_count(const Servo& servo, Key key) {
  return key.index == canopen::warning_counts &&
         !fault_set_at(servo, 5).has(static_cast<Fault>(key.sub));
}

bool KnownParameters::put(std::size_t row, Value value) {
  const std::scoped_lock lock(mutex_);
  const bool changed = values_[row] != value;
  values_[row] = value;
  return changed;
}

std::optional<Value> KnownParameters::get(std::size_t row) const {
  const std::scoped_lock lock(mutex_);
  return values_[row];
}

unsigned Servo::value(Key key) const {
  const auto found = values.find(key);
  return found == values.end() ? 0 : found->second;
}

std::int32_t Servo::signed_value(Key key) const {
  return static_cast<std::int32_t>(value(key));
}

bool Servo::may_be_heated() const {
  const unsigned status = statusword();
  return is_enabled() || ((status & 0x6FU) == 0x07 && value({index::quick_stop_option, 0}) == 6) ||
         ((status & 0x4FU) == 0x0F && value({index::fault_option, 0}) == 2);
}

std::string Servo::title() const {
  return name.empty() ? fmt::format("node {}", node) : fmt::format("node {} ({})", node, name);
}

json state_message(const Servo& servo) {
  const unsigned first = servo.value({0x2202, 9});
  const auto& rows = mode_rows();
  const auto mode = std::ranges::find(rows, servo.mode(), &ModeRow::mode);
  json message{{"node", servo.node},
               {"online", servo.online},
               {"nmt", nmt_of(servo)},
               {"drive", drive_name(servo.statusword())},
               {"statusword", servo.statusword()},
               {"mode", servo.mode()},
               {"mode_name", mode == rows.end() ? "none" : mode->name},
               {"target", target_of(servo)},
               {"position_um", servo.signed_value({index::position_actual, 0})},
               {"target_reached", (servo.statusword() & reached_bit_of_status) != 0},
               {"active", fault_names(fault_set_at(servo, 3))},
               {"latched", fault_names(fault_set_at(servo, 1))},
               {"warnings", fault_names(fault_set_at(servo, 5))},
               {"warning_causes", warning_causes(servo)},
               {"blocking", fault_names(fault_set_at(servo, 7))},
               {"first_cause", first == 0 || first >= fault_count
                                   ? json(nullptr)
                                   : json(fault_name(static_cast<Fault>(first)))},
               {"limits", limit_names_of(servo.value({0x2202, 11}))},
               {"freeze_frame", frame_of(servo.freeze_frame)},
               {"transaction", transaction_of(servo)},
               {"unsaved", servo.unsaved},
               {"rate_hz", std::round(10 * servo.rate_hz) / 10},
               {"gaps", servo.gaps}};
  return message;
}

const std::vector<ModeRow>& mode_rows() {
  static const std::vector<ModeRow> rows{{1, "profile position", "um"},
                                         {8, "cyclic position", "um"},
                                         {6, "homing", ""},
                                         {4, "profile force", "0.1 %"},
                                         {10, "cyclic force", "0.1 %"},
                                         {-1, "current", "A"},
                                         {-2, "power", "W"},
                                         {-3, "temperature", "K"},
                                         {-4, "identification", ""}};
  return rows;
}

}  // namespace smaservo::page
