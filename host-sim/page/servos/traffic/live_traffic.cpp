#include "host-sim/page/servos/traffic/live_traffic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "firmware/canopen/node/index.hpp"
#include "firmware/canopen/node/object.hpp"
#include "model/files/error.hpp"

namespace smaservo::page {
namespace {

namespace index = canopen::index;

constexpr std::uint32_t request_id = 0x600;
constexpr std::uint32_t answer_id = 0x580;
constexpr std::int64_t patience_us = 100'000;
constexpr unsigned silences_until_gone = 3;
constexpr std::int64_t state_period_us = 200'000;
/// While nobody looks.
constexpr std::int64_t idle_period_us = 1'000'000;
/// Between the beginnings of two rounds of live values: 80 Hz.
constexpr std::int64_t live_period_us = 12'500;
/// The rate that is promised. What takes longer counts as missing samples.
constexpr std::int64_t promised_us = 20'000;
constexpr std::int64_t renewal_period_us = 250'000;
/// Between two node-ids that are tried in search of new servos.
constexpr std::int64_t search_period_us = 100'000;
constexpr std::int64_t pause_us = 500'000;
/// A servo has one SDO transfer at a time. After a request or an answer of another master's it is
/// left alone for so long, or that one's transfer would be dropped.
constexpr std::int64_t courtesy_us = 30'000;
/// One that never pauses does not keep the bridge from knowing the servo.
constexpr std::int64_t longest_courtesy_us = 5'000'000;

// Two devices with one node-id both answer a request. An answer that comes within second_answer_us
// of another one to the same request is surplus. Three of them (surplus_of_two), none more than
// surplus_memory_us after the one before, prove that there are two devices.
constexpr unsigned surplus_of_two = 3;
constexpr std::int64_t second_answer_us = 50'000;
constexpr std::int64_t surplus_memory_us = 5'000'000;

std::optional<std::size_t> signal_of(Key key) {
  if (key.index != live_values || key.sub == 0 || key.sub > signal_count) {
    return std::nullopt;
  }
  return std::size_t{key.sub} - 1;
}

}  // namespace

LiveTraffic::LiveTraffic(can::Bus& bus, const TrafficPlan& plan, SyncStream& stream,
                         Control& control, TrafficEvents& events)
    : bus_(bus), plan_(plan), stream_(stream), control_(control), events_(events) {}

void LiveTraffic::want(const NodeSet& live, bool anything) {
  live_ = live;
  anything_ = anything;
}

void LiveTraffic::refresh(unsigned node) {
  links_[node].state_at = 0;
  links_[node].state_due_us = 0;
}

Servo* LiveTraffic::servo_of(unsigned node) {
  const auto found = servos_.find(node);
  return found == servos_.end() ? nullptr : &found->second;
}

bool LiveTraffic::waits_for(unsigned node, std::int64_t now_us) {
  look_for_silence(node, now_us);
  return links_[node].waits;
}

// What is heard.

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
    links_[node].foreign_us = now_us;
    links_[node].hold_until_us = now_us + courtesy_us;
  } else if (function == 14 && frame.length == 1) {
    Servo* const servo = servo_of(node);
    candidates_.set(node, servo == nullptr || !servo->online);
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
    // TPDO1 as it is by default: statusword, mode, error code.
    const Servo* const servo = servo_of(node);
    if (servo != nullptr &&
        servo->statusword() != canopen::take_number(std::span(frame.data).first(2))) {
      refresh(node);
    }
  }
}

void LiveTraffic::answered(unsigned node, const hal::CanFrame& frame, std::int64_t now_us) {
  Link& link = links_[node];
  const Key key{
      static_cast<std::uint16_t>(canopen::take_number(std::span(frame.data).subspan(1, 2))),
      frame.data[3]};
  const unsigned command = frame.data[0] & 0xE0U;
  const bool keyed = command == 0x40 || command == 0x60 || command == 0x80;
  if (!link.waits || !keyed || key != link.key) {
    if (keyed && key == link.answered && !is_busy(node)) {
      surplus_answer(node, link, now_us);
    }
    if (now_us < link.hold_until_us) {
      link.hold_until_us = now_us + courtesy_us;
    }
    return;
  }
  link.waits = false;
  link.answered = key;
  link.answered_us = now_us;
  link.silences = 0;
  Servo* const servo = servo_of(node);
  if (servo == nullptr || !servo->online) {
    candidates_.reset(node);
    events_.came(node);
    return;
  }
  take(*servo, link, frame, now_us);
}

/// A second answer to a request of ours. Other masters ask, too: then it is theirs.
void LiveTraffic::surplus_answer(unsigned node, Link& link, std::int64_t now_us) {
  if (now_us - link.answered_us > second_answer_us ||
      now_us - link.foreign_us < 2 * second_answer_us) {
    return;
  }
  link.surplus = now_us - link.surplus_us > surplus_memory_us ? 1 : link.surplus + 1;
  link.surplus_us = now_us;
  Servo* const servo = servo_of(node);
  if (servo != nullptr && link.surplus >= surplus_of_two && !servo->duplicate) {
    servo->duplicate = true;
    events_.doubled(*servo);
  }
}

void LiveTraffic::take(Servo& servo, Link& link, const hal::CanFrame& frame, std::int64_t now_us) {
  const bool expedited = (frame.data[0] & 0xE2U) == 0x42;
  const auto value = [&] {
    const std::size_t unused = (frame.data[0] & 1U) != 0 ? (frame.data[0] >> 2U) & 3U : 0;
    return static_cast<std::uint32_t>(
        canopen::take_number(std::span(frame.data).subspan(4, 4 - unused)));
  };
  if (link.reason == Reason::live) {
    take_live(servo, link, expedited ? std::optional(canopen::as_real(value())) : std::nullopt,
              now_us);
  } else if (link.reason == Reason::state && expedited) {
    take_state(servo, link, value(), link.sent_us, now_us);
  }
}

void LiveTraffic::take_state(Servo& servo, Link& link, std::uint32_t value, std::int64_t sent_us,
                             std::int64_t now_us) {
  servo.values[link.key] = value;
  const bool is_status = link.key == Key{index::statusword, 0};
  // A statusword of before the axis was enabled says nothing.
  if (is_status && servo.enabled_us != 0 && servo.enabled_us < sent_us && !servo.may_be_heated()) {
    servo.enabled_us = 0;
    control_.cooled(servo.node);
  }
  if (servo.duplicate && now_us - link.surplus_us > surplus_memory_us) {
    servo.duplicate = false;
  }
  const std::size_t objects = anything_ ? state_objects().size() : 1;
  if (link.state_at >= objects) {
    events_.state_read(servo);
  }
}

void LiveTraffic::take_live(Servo& servo, Link& link, std::optional<float> value,
                            std::int64_t now_us) {
  const std::optional<std::size_t> signal = signal_of(link.key);
  if (signal && value) {
    Sample& sample = link.live_at <= link.round.fast.size() ? link.sample : link.slow_sample;
    sample.has.set(*signal);
    sample.values[*signal] = *value;
    sample.time_us = now_us;
  }
  if (link.live_at == link.round.fast.size() && link.live_at != 0) {
    const std::int64_t since_us = now_us - link.live_last_us;
    if (link.live_last_us != 0 && since_us >= 2 * promised_us) {
      link.polled_gaps += static_cast<std::uint64_t>(since_us / promised_us - 1);
    }
    link.live_last_us = now_us;
    if (link.sample.has.any()) {
      sample(servo, link, link.sample, now_us);
    }
  }
  if (link.live_at < link.round.fast.size() + (link.round.slow.empty() ? 0 : 1)) {
    return;
  }
  link.in_round = false;
  if (++link.slow_at < link.round.slow.size()) {
    return;
  }
  link.slow_at = 0;
  if (link.slow_sample.has.any()) {
    events_.sampled(servo, link.slow_sample);
  }
  link.slow_sample = {};
}

void LiveTraffic::sample(Servo& servo, Link& link, const Sample& sample, std::int64_t now_us) {
  ++link.rate_count;
  if (now_us - link.rate_since_us >= 1'000'000) {
    servo.rate_hz = 1e6 * link.rate_count / static_cast<double>(now_us - link.rate_since_us);
    link.rate_since_us = now_us;
    link.rate_count = 0;
  }
  servo.gaps = link.polled_gaps + stream_.gaps(servo.node);
  events_.sampled(servo, sample);
}

/// A client's write that commands, which is what a renewal repeats.
void LiveTraffic::said(const hal::CanFrame& frame, std::int64_t now_us) {
  if (frame.id <= request_id || frame.id > request_id + 127 || (frame.data[0] & 0xE2U) != 0x22) {
    return;
  }
  Servo* const servo = servo_of(frame.id - request_id);
  if (servo == nullptr) {
    return;
  }
  const Key key{
      static_cast<std::uint16_t>(canopen::take_number(std::span(frame.data).subspan(1, 2))),
      frame.data[3]};
  if (key == Key{index::controlword, 0}) {
    servo->commanded.word =
        static_cast<std::uint16_t>(canopen::take_number(std::span(frame.data).subspan(4, 2)));
    servo->commanded.time_us = now_us;
  } else if (key == Key{index::mode, 0}) {
    servo->commanded.mode = static_cast<std::int8_t>(frame.data[4]);
  }
}

// What is sent.

/// Reads an object, or writes one of two bytes.
void LiveTraffic::ask(unsigned node, Key key, Reason reason, std::int64_t now_us,
                      std::optional<std::uint16_t> value) {
  hal::CanFrame frame{.id = request_id + node, .length = 8, .data = {}};
  frame.data[0] = value ? 0x2B : 0x40;
  canopen::put_number(std::span(frame.data).subspan(4, 2), value.value_or(0));
  canopen::put_number(std::span(frame.data).subspan(1, 2), key.index);
  frame.data[3] = key.sub;
  Link& link = links_[node];
  link.key = key;
  link.reason = reason;
  link.sent_us = now_us;
  link.waits = true;
  allowed_ -= 1;
  bus_.send(frame);
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
  link.live_last_us = 0;
  link.in_round = false;
  servo->online = false;
  servo->rate_hz = 0;
  events_.left(*servo);
}

/// Repeats the last command to each axis that a client with control has enabled.
void LiveTraffic::renew(std::int64_t now_us) {
  const NodeSet heated = control_.heated();
  for (unsigned node = 1; heated.any() && node < heated.size(); ++node) {
    Servo* const servo = heated[node] ? servo_of(node) : nullptr;
    if (servo == nullptr || !servo->online || servo->duplicate || servo->enabled_us == 0) {
      continue;
    }
    Commanded& last = servo->commanded;
    if (!last.word || now_us - last.time_us < renewal_period_us) {
      continue;
    }
    const bool operational = (servo->statusword() & 0x200U) != 0;
    if (last.by_pdo && operational) {
      hal::CanFrame frame{.id = 0x200 + node, .length = 3, .data = {}};
      canopen::put_number(std::span(frame.data).first(2), *last.word);
      frame.data[2] =
          static_cast<std::uint8_t>(last.mode.value_or(static_cast<std::int8_t>(servo->mode())));
      bus_.send(frame);
    } else if (!is_busy(node) && !links_[node].waits) {
      ask(node, {index::controlword, 0}, Reason::renewal, now_us, last.word);
    } else {
      continue;
    }
    last.time_us = now_us;
  }
}

bool LiveTraffic::poll_state(Servo& servo, Link& link, std::int64_t now_us) {
  const auto& objects = state_objects();
  const std::size_t wanted = anything_ ? objects.size() : 1;
  if (link.state_at >= wanted) {
    link.state_at = 0;
    link.state_due_us = now_us + (anything_ ? state_period_us : idle_period_us);
  }
  if (now_us < link.state_due_us) {
    return false;
  }
  ask(servo.node, objects[link.state_at++].key, Reason::state, now_us);
  return true;
}

void LiveTraffic::begin_round(unsigned node, Link& link) {
  const auto servos = static_cast<double>(std::max<std::size_t>(live_.count(), 1));
  const double state_per_s = 1e6 / state_period_us * static_cast<double>(state_objects().size());
  link.round = live_round(plan_.requests_per_s / servos - state_per_s,
                          stream_.is_mapped(node) ? &stream_.signals() : nullptr);
  link.sample = {};
  link.live_at = 0;
  link.in_round = !link.round.fast.empty() || !link.round.slow.empty();
}

bool LiveTraffic::poll_live(Servo& servo, Link& link, std::int64_t now_us) {
  if (!live_[servo.node]) {
    link.in_round = false;
    link.live_last_us = 0;
    return false;
  }
  if (!link.in_round) {
    if (now_us < link.live_due_us) {
      return false;
    }
    link.live_due_us = std::max(link.live_due_us + live_period_us, now_us);
    begin_round(servo.node, link);
    if (!link.in_round) {
      return false;
    }
  }
  const std::size_t at = link.live_at++;
  const std::size_t signal =
      at < link.round.fast.size()
          ? link.round.fast[at]
          : link.round.slow[std::min(link.slow_at, link.round.slow.size() - 1)];
  ask(servo.node, {live_values, sub_of(signal)}, Reason::live, now_us);
  return true;
}

void LiveTraffic::poll(unsigned node, std::int64_t now_us) {
  Link& link = links_[node];
  look_for_silence(node, now_us);
  const bool holds = now_us < link.hold_until_us && now_us - link.answered_us < longest_courtesy_us;
  if (link.waits || is_busy(node) || allowed_ < 1 || holds) {
    return;
  }
  Servo* const servo = servo_of(node);
  if (servo == nullptr || !servo->online) {
    const bool is_due = link.next_try_us <= now_us;
    if (!is_due || (servo == nullptr && !candidates_[node])) {
      return;
    }
    link.next_try_us = now_us + pause_us;
    candidates_.reset(node);
    ask(node, {index::device_type, 0}, Reason::probe, now_us);
    return;
  }
  // The state goes before, or a full round of live values would keep it away for ever.
  if (!poll_state(*servo, link, now_us)) {
    poll_live(*servo, link, now_us);
  }
}

/// Tries one node-id after the other, so that a servo is found that says nothing by itself.
void LiveTraffic::search(std::int64_t now_us) {
  if (now_us - search_us_ < search_period_us) {
    return;
  }
  search_us_ = now_us;
  if (servo_of(search_at_) == nullptr) {
    candidates_.set(search_at_);
  }
  search_at_ = search_at_ % 127 + 1;
}

void LiveTraffic::send(std::int64_t now_us) {
  const double most = std::max(4.0, plan_.requests_per_s / 100);
  allowed_ = std::min(
      most, allowed_ + plan_.requests_per_s * 1e-6 * static_cast<double>(now_us - allowed_us_));
  allowed_us_ = now_us;
  renew(now_us);
  search(now_us);
  turn_ = turn_ % 127 + 1;
  for (unsigned i = 0; i < 127; ++i) {
    const unsigned node = (turn_ + i) % 127 + 1;
    if (candidates_[node] || links_[node].waits || servo_of(node) != nullptr) {
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
