#include "firmware/canopen/node/node.hpp"

#include <utility>

namespace smaservo::canopen {
namespace {

// Identifiers of the predefined connection set.
constexpr std::uint32_t nmt_id = 0x000;
constexpr std::uint32_t sdo_answer_id = 0x580;
constexpr std::uint32_t sdo_request_id = 0x600;
constexpr std::uint32_t heartbeat_id = 0x700;

constexpr std::uint8_t generic_error = 0x01;
constexpr std::uint8_t communication_error = 0x10;
constexpr std::uint16_t sync_length = 0x8240;

/// Whether the error is a frame of a wrong length: the frame has no effect, and its sender may
/// repeat it for ever.
bool is_mild(std::uint16_t code) {
  return code == static_cast<std::uint16_t>(PdoEvent::too_short) ||
         code == static_cast<std::uint16_t>(PdoEvent::too_long) || code == sync_length;
}

hal::CanFrame frame_of(std::uint32_t id, std::uint8_t length) {
  hal::CanFrame frame;
  frame.id = id;
  frame.length = length;
  return frame;
}

}  // namespace

// Starting.

bool Node::start(std::span<const std::uint8_t> image, std::uint64_t now_us) {
  const bool only_communication = request_ == Request::reset_communication;
  now_us_ = heartbeat_us_ = sync_us_ = now_us;
  consumers_ = {};
  emergencies_waiting_ = 0;
  application_errors_ = 0;
  conditions_ = 0;
  lost_ = wrong_sync_ = duplicated_ = emergency_sent_ = sync_alive_ = lss_waits_ = false;
  request_ = Request::none;
  sdo_.reset();
  const bool good = load_image(image, only_communication);
  lss_.reset(node_id_, lss_bit_rate_ == unconfigured ? config_.bit_rate : lss_bit_rate_);
  state_ = Nmt::initialising;
  application_.started(node_id_);
  pdos_.reset();
  boots_ = node_id_ != unconfigured;
  if (boots_) {
    enter(Nmt::pre_operational);
  }
  return good;
}

void Node::enter(Nmt state) {
  if (state == state_) {
    return;
  }
  state_ = state;
  pdos_.stop();
  wrong_sync_ = false;
  show_errors();
  if (!communicates()) {
    sdo_.reset();
  }
  application_.nmt_changed(state);
}

void Node::command(const hal::CanFrame& frame) {
  if (frame.length != 2 || (frame.data[1] != 0 && frame.data[1] != node_id_)) {
    return;
  }
  switch (frame.data[0]) {
    case 1:
      enter(Nmt::operational);
      break;
    case 2:
      enter(Nmt::stopped);
      break;
    case 128:
      enter(Nmt::pre_operational);
      break;
    case 129:
    case 130:
      raise(frame.data[0] == 129 ? Request::reset_node : Request::reset_communication);
      enter(Nmt::initialising);
      break;
    default:
      break;
  }
}

void Node::raise(Request request) {
  request_ = request;
  ++request_number_;
}

/// Accepts one request at a time. Only a reset (command()) replaces a waiting request; it makes the
/// node silent until it is started.
Abort Node::ask(Request request) {
  if (request_ != Request::none) {
    return Abort::state;
  }
  const Abort refused = application_.may_request(request);
  if (refused == Abort::none) {
    raise(request);
  }
  return refused == Abort::none ? Abort::pending : refused;
}

void Node::finish(std::uint32_t number, bool done) {
  const Request request = request_;
  if (number != request_number_ || request == Request::none || request == Request::reset_node ||
      request == Request::reset_communication) {
    return;
  }
  request_ = Request::none;
  if (request == Request::store_lss) {
    if (!done) {
      // Values that could not be stored must not be stored later together with others.
      lss_node_id_ = lss_before_.node_id;
      lss_bit_rate_ = lss_before_.bit_rate;
    }
    if (std::exchange(lss_waits_, false)) {
      lss_.finish_store(done);
    }
  } else if (request != Request::bit_rate) {
    sdo_.finish(done ? Abort::none : Abort::hardware);
  }
}

// Frames in.

void Node::receive(const hal::CanFrame& frame, std::uint64_t now_us) {
  now_us_ = now_us;
  if (frame.extended || frame.length > 8) {
    return;
  }
  if (frame.id == lss_request_id && !frame.remote) {
    receive_lss(frame);
    return;
  }
  if (state_ == Nmt::initialising) {
    return;
  }
  if (frame.id == nmt_id && !frame.remote) {
    command(frame);
    return;
  }
  if (frame.id == sdo_request_id + node_id_ && !frame.remote) {
    if (frame.length == 8 && communicates()) {
      sdo_.receive(frame.data, now_us);
    }
    return;
  }
  if (heartbeat_id < frame.id && frame.id <= heartbeat_id + 127 && !frame.remote) {
    receive_heartbeat(frame);
    return;
  }
  if (frame.id == (objects_.sync_cob & cob_id_mask) && !frame.remote) {
    receive_sync(frame);
    return;
  }
  if (state_ != Nmt::operational) {
    return;
  }
  const PdoEvent event = pdos_.receive(frame, now_us);
  if (event != PdoEvent::ignored && !frame.remote) {
    find_again();
    show_errors();
  }
  if (event == PdoEvent::too_short || event == PdoEvent::too_long) {
    emergency(static_cast<std::uint16_t>(event), frame.id);
  }
}

void Node::receive_sync(const hal::CanFrame& frame) {
  if (state_ != Nmt::operational) {
    return;
  }
  const std::uint8_t length = objects_.sync_overflow == 0 ? 0 : 1;
  const bool is_new = !wrong_sync_;
  wrong_sync_ = frame.length != length;
  show_errors();
  if (wrong_sync_) {
    if (is_new) {
      emergency(sync_length, frame.length);
    }
    return;
  }
  sync_us_ = now_us_;
  sync_alive_ = true;
  pdos_.sync(length == 0 ? std::uint8_t{0} : frame.data[0]);
}

void Node::receive_heartbeat(const hal::CanFrame& frame) {
  if (frame.length != 1) {
    return;
  }
  const std::uint32_t id = frame.id - heartbeat_id;
  if (id == node_id_) {
    duplicated_ = true;
    return;
  }
  for (std::size_t i = 0; i < consumer_count; ++i) {
    const std::uint32_t watched = objects_.consumers[i];
    if ((watched >> 16U & 0x7FU) == id && (watched & 0xFFFFU) != 0) {
      consumers_[i] = {now_us_, true, false};
    }
  }
  find_again();
}

/// The communication error of 1001h ends when all watched sources have come back.
void Node::find_again() {
  const bool any_lost =
      std::ranges::any_of(consumers_, [](const Consumer& consumer) { return consumer.lost; });
  if (lost_ && !any_lost && pdos_.on_time()) {
    lost_ = false;
    show_errors();
  }
}

void Node::receive_lss(const hal::CanFrame& frame) {
  if (frame.length != 8 || request_ == Request::reset_node ||
      request_ == Request::reset_communication) {
    return;
  }
  const bool was_configuring = lss_.configures();
  switch (lss_.receive(frame.data)) {
    case LssAction::none:
      break;
    case LssAction::node_id:
      if (was_configuring && !lss_.configures() && node_id_ == unconfigured) {
        raise(Request::reset_communication);
      }
      break;
    case LssAction::store:
      store_lss();
      break;
    case LssAction::activate:
      ask(Request::bit_rate);
      break;
  }
}

/// LSS requests have no numbers: the master takes the next answer as that to its last request. So
/// when a request is refused while an earlier one is being carried out, the earlier one gets no
/// answer.
void Node::store_lss() {
  if (ask(Request::store_lss) != Abort::pending) {
    lss_waits_ = false;
    lss_.finish_store(false);
    return;
  }
  lss_waits_ = true;
  lss_before_ = {lss_node_id_, lss_bit_rate_};
  lss_node_id_ = lss_.pending_node_id();
  lss_bit_rate_ = lss_.pending_bit_rate();
}

// Time.

void Node::advance(std::uint64_t now_us) {
  now_us_ = now_us;
  if (state_ == Nmt::initialising) {
    return;
  }
  if (communicates()) {
    sdo_.advance(now_us);
  }
  watch_consumers();
  if (state_ == Nmt::operational) {
    watch_sync();
    if (pdos_.advance(now_us) == PdoEvent::timed_out) {
      lose(static_cast<std::uint16_t>(PdoEvent::timed_out), 0);
    }
  }
}

void Node::watch_consumers() {
  for (std::size_t i = 0; i < consumer_count; ++i) {
    Consumer& consumer = consumers_[i];
    const std::uint32_t watched = objects_.consumers[i];
    const std::uint64_t time_us = 1000ULL * (watched & 0xFFFFU);
    if (consumer.alive && time_us != 0 && time_us <= now_us_ - consumer.came_us) {
      consumer = {consumer.came_us, false, true};
      lose(heartbeat_lost, static_cast<std::uint8_t>(watched >> 16U));
    }
  }
}

void Node::watch_sync() {
  const std::uint64_t period_us = objects_.sync_period_us;
  if (sync_alive_ && period_us != 0 && 2 * period_us <= now_us_ - sync_us_) {
    sync_alive_ = false;
  }
}

/// Loss of a watched source: 1029h decides the state of the node, the application what happens to
/// the wire.
void Node::lose(std::uint16_t code, std::uint8_t who) {
  lost_ = true;
  show_errors();
  emergency(code, who);
  application_.connection_lost(code);
  if (objects_.error_behaviour == 0 && state_ == Nmt::operational) {
    enter(Nmt::pre_operational);
  } else if (objects_.error_behaviour == 2) {
    enter(Nmt::stopped);
  }
}

std::uint16_t Node::missing() const {
  if (objects_.sync_period_us != 0 && !sync_alive_) {
    return sync_lost;
  }
  bool watched = false;
  for (std::size_t i = 0; i < consumer_count; ++i) {
    if ((objects_.consumers[i] & 0xFFFFU) != 0) {
      watched = true;
      if (!consumers_[i].alive) {
        return heartbeat_lost;
      }
    }
  }
  const bool late = !watched && pdos_.has_deadline() && !pdos_.on_time();
  return late ? static_cast<std::uint16_t>(PdoEvent::timed_out) : std::uint16_t{0};
}

Supervision Node::supervision() const {
  using enum Supervision;
  const bool watched = std::ranges::any_of(
      objects_.consumers, [](std::uint32_t consumer) { return (consumer & 0xFFFFU) != 0; });
  return missing() != 0 ? gone : watched || pdos_.has_deadline() ? alive : none;
}

// Emergencies.

void Node::emergency(std::uint16_t code, std::uint64_t info) {
  remember(code, info);
  queue({info, code, objects_.error_register});
}

/// Adds an entry to 1003h, newest first. If the list is full, the oldest mild entry is removed; a
/// mild entry is not added if all others are severe.
void Node::remember(std::uint16_t code, std::uint64_t info) {
  const std::span history(objects_.errors);
  std::size_t last = objects_.error_count;
  if (last == error_history) {
    --last;
    while (last > 0 && !is_mild(static_cast<std::uint16_t>(history[last]))) {
      --last;
    }
    const bool found = is_mild(static_cast<std::uint16_t>(history[last]));
    if (!found && is_mild(code)) {
      return;
    }
    last = found ? last : error_history - 1;
  } else {
    ++objects_.error_count;
  }
  std::ranges::copy_backward(history.first(last), history.first(last + 1).end());
  history[0] = code | static_cast<std::uint32_t>(info & 0xFFFFU) << 16U;
}

/// Queues an EMCY. The newest always gets a place, so that the last EMCY on the bus agrees with
/// 1001h. If the queue is full, the oldest that is mild or says that an error has ended is dropped,
/// otherwise the oldest.
void Node::queue(const Emergency& emergency) {
  if (state_ == Nmt::initialising) {
    return;
  }
  const auto waiting = std::span(emergencies_).first(emergencies_waiting_);
  if (waiting.size() == error_history) {
    const auto least = std::ranges::find_if(
        waiting, [](const Emergency& e) { return e.code == 0 || is_mild(e.code); });
    const auto leaves = least == waiting.end() ? waiting.begin() : least;
    std::copy(leaves + 1, waiting.end(), leaves);
    --emergencies_waiting_;
  }
  emergencies_[emergencies_waiting_++] = emergency;
}

void Node::set_errors(std::uint8_t bits) {
  if (bits != application_errors_) {
    application_errors_ = bits;
    show_errors();
  }
}

/// Updates 1001h from the present conditions. When a condition has ended, an EMCY with the
/// remaining ones is queued.
void Node::show_errors() {
  const std::uint8_t before = objects_.error_register;
  const unsigned conditions = (lost_ ? 1U : 0U) + (wrong_sync_ ? 1U : 0U) + pdos_.wrong_lengths();
  const auto bus = conditions != 0 ? communication_error | generic_error : 0;
  objects_.error_register = static_cast<std::uint8_t>(application_errors_ | bus);
  const bool ended = conditions < conditions_ || (before & ~objects_.error_register) != 0;
  conditions_ = conditions;
  if (ended) {
    queue({0, 0, objects_.error_register});
  }
}

// Frames out.

bool Node::take(hal::CanFrame& frame) {
  if (lss_.take(std::span<std::uint8_t, 8>(frame.data))) {
    const auto data = frame.data;
    frame = frame_of(lss_answer_id, 8);
    frame.data = data;
    return true;
  }
  if (state_ == Nmt::initialising) {
    return false;
  }
  return take_heartbeat(frame) || take_emergency(frame) ||
         (state_ == Nmt::operational && pdos_.take(frame, now_us_)) || take_answer(frame);
}

bool Node::take_heartbeat(hal::CanFrame& frame) {
  const std::uint64_t period_us = 1000ULL * objects_.heartbeat_ms;
  const bool due = period_us != 0 && period_us <= now_us_ - heartbeat_us_;
  if (!boots_ && !due) {
    return false;
  }
  // The next heartbeat is timed from when this one was due, unless it is very late.
  heartbeat_us_ =
      boots_ || 2 * period_us <= now_us_ - heartbeat_us_ ? now_us_ : heartbeat_us_ + period_us;
  frame = frame_of(heartbeat_id + node_id_, 1);
  frame.data[0] = boots_ ? std::uint8_t{0} : static_cast<std::uint8_t>(state_);
  boots_ = false;
  return true;
}

bool Node::take_emergency(hal::CanFrame& frame) {
  if (!communicates() || emergencies_waiting_ == 0) {
    return false;
  }
  if ((objects_.emergency_cob & cob_invalid) != 0) {
    emergencies_waiting_ = 0;
    return false;
  }
  const std::uint64_t inhibit_us = 100ULL * objects_.emergency_inhibit_100us;
  if (emergency_sent_ && now_us_ - emergency_us_ < inhibit_us) {
    return false;
  }
  emergency_us_ = now_us_;
  emergency_sent_ = true;
  const Emergency e = emergencies_[0];
  std::ranges::copy(std::span(emergencies_).subspan(1), emergencies_.begin());
  --emergencies_waiting_;
  frame = frame_of(objects_.emergency_cob & cob_id_mask, 8);
  put_number(std::span(frame.data).first(2), e.code);
  frame.data[2] = e.errors;
  put_number(std::span(frame.data).subspan(3), e.info);
  return true;
}

bool Node::take_answer(hal::CanFrame& frame) {
  if (!communicates()) {
    return false;
  }
  std::array<std::uint8_t, 8> data{};
  if (!sdo_.take(data)) {
    return false;
  }
  frame = frame_of(sdo_answer_id + node_id_, 8);
  frame.data = data;
  return true;
}

}  // namespace smaservo::canopen
