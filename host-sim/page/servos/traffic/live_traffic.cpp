#include "host-sim/page/servos/traffic/live_traffic.hpp"

#include <algorithm>

#include "firmware/canopen/node/index.hpp"
#include "firmware/canopen/node/object.hpp"
#include "host-sim/page/servos/traffic/expedited.hpp"
#include "model/files/error.hpp"

namespace smaservo::page {
namespace {

namespace index = canopen::index;

constexpr std::uint32_t request_id = 0x600;
constexpr std::int64_t patience_us = 100'000;
constexpr unsigned silences_until_gone = 3;
constexpr std::int64_t pause_us = 500'000;
}  // namespace

LiveTraffic::LiveTraffic(can::Bus& bus, const TrafficPlan& plan, SyncStream& stream,
                         Control& control, TrafficEvents& events)
    : bus_(bus), plan_(plan), stream_(stream), control_(control), events_(events) {}

void LiveTraffic::want(const NodeSet& live, bool anything) {
  live_ = live;
  anything_ = anything;
}

void LiveTraffic::refresh(unsigned node) {
  links_[node].state.restart();
}

Servo* LiveTraffic::servo_of(unsigned node) {
  const auto found = servos_.find(node);
  return found == servos_.end() ? nullptr : &found->second;
}

bool LiveTraffic::waits_for(unsigned node, std::int64_t now_us) {
  look_for_silence(node, now_us);
  return links_[node].waits;
}

// Received frames.

void LiveTraffic::heard(const hal::CanFrame& frame, std::int64_t now_us) {
  if (frame.extended || frame.remote) {
    return;
  }
  const unsigned node = frame.id & 0x7FU;
  const unsigned function = frame.id >> 7U;
  if (function == 1 && node == 0) {
    stream_.foreign_sync(now_us);
    return;
  }
  if (node == 0) {
    return;
  }
  unsigned sampled = 0;
  Sample complete;
  if (stream_.heard(frame, now_us, sampled, complete)) {
    if (Servo* servo = servo_of(sampled)) {
      sample(*servo, links_[sampled], complete, now_us);
    }
  }
  if (function == 11 && frame.length == 8) {
    answered(node, frame, now_us);
  } else if (function == 12) {
    links_[node].duplicates.foreign_request(now_us);
    links_[node].courtesy.foreign_request(now_us);
  } else if (function == 14 && frame.length == 1) {
    Servo* const servo = servo_of(node);
    search_.propose(node, servo == nullptr || !servo->online);
    if (servo == nullptr) {
      return;
    }
    servo->heartbeat_state = frame.data[0] & 0x7FU;
    if (servo->heartbeat_state == 0U) {
      events_.restarted(*servo);
    }
  } else if (function == 1) {
    refresh(node);
  } else if (function == 3 && frame.length == 5) {
    // TPDO1 in its default mapping: statusword, mode, error code.
    const Servo* const servo = servo_of(node);
    if (servo != nullptr &&
        servo->statusword() != canopen::take_number(std::span(frame.data).first(2))) {
      refresh(node);
    }
  }
}

void LiveTraffic::answered(unsigned node, const hal::CanFrame& frame, std::int64_t now_us) {
  Link& link = links_[node];
  Servo* const servo = servo_of(node);
  const Key key = sdo_key(frame);
  const unsigned command = frame.data[0] & 0xE0U;
  const bool keyed = command == 0x40 || command == 0x60 || command == 0x80;
  if (!link.waits || !keyed || key != link.key) {
    const bool two = keyed && !is_busy(node) && link.duplicates.answered_again(key, now_us);
    if (two && servo != nullptr && !servo->duplicate) {
      servo->duplicate = true;
      events_.doubled(*servo);
    }
    link.courtesy.foreign_answer(now_us);
    return;
  }
  link.waits = false;
  link.duplicates.answered(key, now_us);
  link.courtesy.answered(now_us);
  link.silences = 0;
  if (servo == nullptr || !servo->online) {
    search_.propose(node, false);
    events_.came(node);
    return;
  }
  const std::optional<std::uint32_t> value = sdo_value(frame);
  if (link.reason == Reason::live) {
    take_live(*servo, link, value, now_us);
  } else if (link.reason == Reason::state && value) {
    take_state(*servo, link, *value, now_us);
  }
}

void LiveTraffic::take_state(Servo& servo, Link& link, std::uint32_t value, std::int64_t now_us) {
  servo.values[link.key] = value;
  const bool is_status = link.key == Key{index::statusword, 0};
  // A statusword that was requested before the axis was enabled is ignored.
  if (is_status && servo.enabled_us != 0 && servo.enabled_us < link.sent_us &&
      !servo.may_be_heated()) {
    servo.enabled_us = 0;
    control_.cooled(servo.node);
  }
  if (servo.duplicate && link.duplicates.is_over(now_us)) {
    servo.duplicate = false;
  }
  if (link.state.is_complete(anything_)) {
    events_.state_read(servo);
  }
}

void LiveTraffic::take_live(Servo& servo, Link& link, std::optional<std::uint32_t> value,
                            std::int64_t now_us) {
  const LiveRound::Completed completed =
      link.live.take(value ? std::optional(canopen::as_real(*value)) : std::nullopt, now_us);
  if (completed.fast) {
    sample(servo, link, *completed.fast, now_us);
  }
  if (completed.slow) {
    events_.sampled(servo, *completed.slow);
  }
}

void LiveTraffic::sample(Servo& servo, Link& link, const Sample& sample, std::int64_t now_us) {
  servo.rate_hz = link.rate.count(now_us).value_or(servo.rate_hz);
  servo.gaps = link.live.gaps() + stream_.gaps(servo.node);
  events_.sampled(servo, sample);
}

/// Notes a command that a client writes; renew() repeats the last one.
void LiveTraffic::said(const hal::CanFrame& frame, std::int64_t now_us) {
  Servo* const servo = frame.id > request_id ? servo_of(frame.id - request_id) : nullptr;
  if (servo != nullptr) {
    note_command(frame, now_us, servo->commanded);
  }
}

// Sent frames.

/// Requests an object, or writes this value of two bytes to it.
void LiveTraffic::ask(unsigned node, Key key, Reason reason, std::int64_t now_us,
                      std::optional<std::uint16_t> value) {
  Link& link = links_[node];
  link.key = key;
  link.reason = reason;
  link.sent_us = now_us;
  link.waits = true;
  allowed_ -= 1;
  bus_.send(sdo_request(node, key, value));
}

void LiveTraffic::look_for_silence(unsigned node, std::int64_t now_us) {
  Link& link = links_[node];
  if (!link.waits || now_us - link.sent_us < patience_us) {
    return;
  }
  link.waits = false;
  Servo* const servo = servo_of(node);
  if (servo == nullptr || !servo->online) {
    return;
  }
  if (link.reason == Reason::live) {
    take_live(*servo, link, std::nullopt, now_us);
  }
  if (++link.silences < silences_until_gone) {
    return;
  }
  link.silences = 0;
  link.live.stop();
  servo->online = false;
  servo->rate_hz = 0;
  events_.left(*servo);
}

/// Repeats the last command to each axis that a client with control has enabled.
void LiveTraffic::renew(std::int64_t now_us) {
  const NodeSet heated = control_.heated();
  for (unsigned node = 1; heated.any() && node < heated.size(); ++node) {
    Servo* const servo = heated[node] ? servo_of(node) : nullptr;
    if (servo == nullptr || !needs_renewal(*servo, now_us)) {
      continue;
    }
    Commanded& last = servo->commanded;
    const bool operational = (servo->statusword() & 0x200U) != 0;
    if (last.by_pdo && operational) {
      bus_.send(command_pdo(*servo));
    } else if (!is_busy(node) && !links_[node].waits) {
      ask(node, {index::controlword, 0}, Reason::renewal, now_us, last.word);
    } else {
      continue;
    }
    last.time_us = now_us;
  }
}

void LiveTraffic::poll_live(Servo& servo, Link& link, std::int64_t now_us) {
  if (!live_[servo.node]) {
    link.live.stop();
    return;
  }
  if (!link.live.is_running() && link.live.is_due(now_us)) {
    const auto servos = static_cast<double>(std::max<std::size_t>(live_.count(), 1));
    link.live.begin(polled_signals(plan_.requests_per_s / servos - StateRound::requests_per_s(),
                                   stream_.is_mapped(servo.node) ? &stream_.signals() : nullptr),
                    now_us);
  }
  if (link.live.is_running()) {
    ask(servo.node, {live_values, sub_of(link.live.next())}, Reason::live, now_us);
  }
}

void LiveTraffic::poll(unsigned node, std::int64_t now_us) {
  Link& link = links_[node];
  look_for_silence(node, now_us);
  if (link.waits || is_busy(node) || allowed_ < 1 || link.courtesy.forbids(now_us)) {
    return;
  }
  Servo* const servo = servo_of(node);
  if (servo == nullptr || !servo->online) {
    if (search_.takes(node, servo != nullptr, now_us)) {
      ask(node, {index::device_type, 0}, Reason::probe, now_us);
    }
    return;
  }
  // The state has priority, or full rounds of live values would never let it be read.
  if (const std::optional<Key> key = link.state.next(*servo, anything_, now_us)) {
    ask(node, *key, Reason::state, now_us);
  } else {
    poll_live(*servo, link, now_us);
  }
}

void LiveTraffic::send(std::int64_t now_us) {
  const double most = std::max(4.0, plan_.requests_per_s / 100);
  allowed_ = std::min(
      most, allowed_ + plan_.requests_per_s * 1e-6 * static_cast<double>(now_us - allowed_us_));
  allowed_us_ = now_us;
  renew(now_us);
  search_.tick(now_us, [this](unsigned node) { return servo_of(node) != nullptr; });
  turn_ = turn_ % 127 + 1;
  for (unsigned i = 0; i < 127; ++i) {
    const unsigned node = (turn_ + i) % 127 + 1;
    if (search_.is_proposed(node) || links_[node].waits || servo_of(node) != nullptr) {
      poll(node, now_us);
    }
  }
}

std::int64_t LiveTraffic::tick(std::int64_t now_us) {
  std::int64_t next_us = now_us + (anything_ ? 1000 : 10'000);
  if (pause_until_us_ <= now_us) {
    try {
      next_us = std::min(next_us, stream_.tick(bus_, now_us));
      send(now_us);
      next_us = std::min(next_us, stream_.tick(bus_, bus_.now_us()));
    } catch (const files::UserError& error) {
      pause_until_us_ = now_us + pause_us;
      events_.trouble(error.what());
    }
  }
  events_.ticked(now_us);
  return next_us;
}

}  // namespace smaservo::page
