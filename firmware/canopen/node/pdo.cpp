#include "firmware/canopen/node/pdo.hpp"

#include <algorithm>
#include <utility>

namespace smaservo::canopen {
namespace {

constexpr std::uint8_t max_syncs = 240;
constexpr std::uint8_t first_event_type = 254;

bool is_valid(const PdoParams& params) {
  return (params.cob & cob_invalid) == 0;
}
/// Whether the PDO is valid and has mapped objects. Otherwise it is not sent, and a frame with its
/// identifier is ignored.
bool is_used(const PdoParams& params, const Mapping& map) {
  return is_valid(params) && map.count != 0;
}
bool is_type(std::uint32_t type) {
  return type <= max_syncs || first_event_type <= type;
}
bool is_transmit(std::uint16_t index) {
  return (index & 0x0800U) != 0;
}
bool is_mapping(std::uint16_t index) {
  return (index & 0x0200U) != 0;
}

Key key_of(std::uint32_t object) {
  return {static_cast<std::uint16_t>(object >> 16U), static_cast<std::uint8_t>(object >> 8U)};
}
std::uint32_t bits_of(std::uint32_t object) {
  return object & 0xFFU;
}

/// The dummy objects 0001h to 0007h fill unused bytes in an RPDO; their values are ignored.
bool is_dummy(std::uint32_t object) {
  const Key key = key_of(object);
  return 1 <= key.index && key.index <= 7 && key.sub == 0;
}

std::span<const std::uint32_t> objects_of(const Mapping& map) {
  return std::span(map.objects).first(map.count);
}

std::uint32_t length_of(const Mapping& map) {
  std::uint32_t bits = 0;
  for (const std::uint32_t object : objects_of(map)) {
    bits += bits_of(object);
  }
  return bits / 8;
}

bool has_elapsed(std::uint64_t now_us, std::uint64_t since_us, std::uint64_t for_us) {
  return for_us <= now_us - since_us;
}

}  // namespace

// Configuration.

void Pdos::reset() {
  tx_ = {};
  rx_ = {};
  const auto settle = [&](PdoParams& params, Mapping& map, bool transmit) {
    if (mapped_count < map.count || check_count(map, map.count, transmit) != Abort::none) {
      map.count = 0;
    }
    if (is_restricted(params.cob & cob_id_mask) || !is_type(params.type)) {
      params.cob |= cob_invalid;
    }
  };
  for (std::size_t i = 0; i < pdo_count; ++i) {
    settle(objects_.rpdo[i], objects_.rpdo_map[i], false);
    settle(objects_.tpdo[i], objects_.tpdo_map[i], true);
  }
}

void Pdos::stop() {
  tx_ = {};
  rx_ = {};
}

Abort Pdos::check(Key key, std::uint32_t value) const {
  const bool transmit = is_transmit(key.index);
  const std::size_t i = key.index % 0x200U;
  const PdoParams& params = (transmit ? objects_.tpdo : objects_.rpdo)[i];
  const Mapping& map = (transmit ? objects_.tpdo_map : objects_.rpdo_map)[i];
  return is_mapping(key.index) ? check_mapping(params, map, key, value)
                               : check_params(params, key, value);
}

Abort Pdos::check_params(const PdoParams& params, Key key, std::uint32_t value) {
  switch (key.sub) {
    case 1: {
      constexpr std::uint32_t unused = ~(cob_invalid | cob_no_remote | cob_id_mask);
      if ((value & unused) != 0) {
        return Abort::value;
      }
      const bool stays_valid = is_valid(params) && (value & cob_invalid) == 0;
      if (stays_valid && ((value ^ params.cob) & cob_id_mask) != 0) {
        return Abort::state;
      }
      return is_restricted(value & cob_id_mask) ? Abort::value : Abort::none;
    }
    case 2:
      return is_type(value) ? Abort::none : Abort::value;
    case 3:
    case 6:
      return is_valid(params) ? Abort::state : Abort::none;
    default:
      return Abort::none;
  }
}

/// The mapping may change only while the PDO is invalid; a mapped object, only while their number
/// is 0.
Abort Pdos::check_mapping(const PdoParams& params, const Mapping& map, Key key,
                          std::uint32_t value) const {
  if (is_valid(params)) {
    return Abort::state;
  }
  const bool transmit = is_transmit(key.index);
  if (key.sub == 0) {
    return mapped_count < value ? Abort::pdo_length : check_count(map, value, transmit);
  }
  if (map.count != 0) {
    return Abort::state;
  }
  return value == 0 ? Abort::none : check_object(value, transmit);
}

Abort Pdos::check_object(std::uint32_t object, bool transmit) const {
  if (is_dummy(object)) {
    const auto type = static_cast<Type>(object >> 16U);
    return !transmit && bits_of(object) == 8 * size_of(type) ? Abort::none : Abort::not_mappable;
  }
  Entry entry{};
  const Abort found = dictionary_.find(key_of(object), entry);
  if (found != Abort::none) {
    return found;
  }
  const bool may = (entry.access & (transmit ? in_tpdo : in_rpdo)) != 0;
  return may && bits_of(object) == 8 * size_of(entry.type) ? Abort::none : Abort::not_mappable;
}

Abort Pdos::check_count(const Mapping& map, std::uint32_t count, bool transmit) const {
  std::uint32_t bits = 0;
  for (const std::uint32_t object : std::span(map.objects).first(count)) {
    const Abort wrong = check_object(object, transmit);
    if (wrong != Abort::none) {
      return wrong;
    }
    bits += bits_of(object);
  }
  return 64 < bits ? Abort::pdo_length : Abort::none;
}

void Pdos::changed(Key key) {
  const std::size_t i = key.index % 0x200U;
  if (is_transmit(key.index)) {
    tx_[i] = {};
  } else {
    rx_[i] = {};
  }
}

// Receiving.

PdoEvent Pdos::receive(const hal::CanFrame& frame, std::uint64_t now_us) {
  if (frame.remote) {
    for (std::size_t i = 0; i < pdo_count; ++i) {
      const PdoParams& params = objects_.tpdo[i];
      if (is_used(params, objects_.tpdo_map[i]) && (params.cob & cob_id_mask) == frame.id &&
          (params.cob & cob_no_remote) == 0) {
        tx_[i].due = true;
        return PdoEvent::none;
      }
    }
    return PdoEvent::ignored;
  }
  PdoEvent event = PdoEvent::ignored;
  for (std::size_t i = 0; i < pdo_count; ++i) {
    const PdoParams& params = objects_.rpdo[i];
    if (!is_used(params, objects_.rpdo_map[i]) || (params.cob & cob_id_mask) != frame.id) {
      continue;
    }
    Receive& rx = rx_[i];
    const std::uint32_t length = length_of(objects_.rpdo_map[i]);
    if (frame.length < length) {
      return std::exchange(rx.was_short, true) ? PdoEvent::none : PdoEvent::too_short;
    }
    const bool is_long = length < frame.length;
    event = is_long && !rx.was_long ? PdoEvent::too_long : PdoEvent::none;
    rx.was_long = is_long;
    rx.was_short = rx.was_short && is_long;
    rx.came_us = now_us;
    rx.watched = true;
    rx.late = false;
    rx.data = frame.data;
    rx.waits = params.type <= max_syncs;
    if (!rx.waits) {
      apply(objects_.rpdo_map[i], rx.data);
    }
  }
  return event;
}

/// If a value is refused, the object keeps the old one, and the other objects are still written.
void Pdos::apply(const Mapping& map, std::span<const std::uint8_t> data) {
  std::size_t at = 0;
  for (const std::uint32_t object : objects_of(map)) {
    const std::size_t size = bits_of(object) / 8;
    Entry entry{};
    if (!is_dummy(object) && dictionary_.find(key_of(object), entry) == Abort::none) {
      dictionary_.write(entry, data.subspan(at, size), Source::rpdo);
    }
    at += size;
  }
}

BusLoad Pdos::load(float step_s) const {
  BusLoad load{};
  const float sync_s = 1e-6F * static_cast<float>(objects_.sync_period_us);
  for (std::size_t i = 0; i < pdo_count; ++i) {
    const PdoParams& params = objects_.tpdo[i];
    if (!is_used(params, objects_.tpdo_map[i])) {
      continue;
    }
    const bool by_event = first_event_type <= params.type;
    const float syncs = static_cast<float>(std::max<std::uint8_t>(params.type, 1));
    const float period_s = by_event
                               ? std::max(1e-4F * static_cast<float>(params.inhibit_100us), step_s)
                               : syncs * sync_s;
    if (period_s <= 0) {
      continue;
    }
    // A frame has 47 bits besides the data. 34 of these and the data may be stuffed: at most one
    // bit after each four.
    const std::uint32_t data = 8 * length_of(objects_.tpdo_map[i]);
    const std::uint32_t stuffed = (33 + data) / 4;
    load.frames += 1 / period_s;
    load.bits += static_cast<float>(47 + data + stuffed) / period_s;
  }
  return load;
}

unsigned Pdos::wrong_lengths() const {
  return static_cast<unsigned>(
      std::ranges::count_if(rx_, [](const Receive& rx) { return rx.was_short || rx.was_long; }));
}

bool Pdos::has_deadline() const {
  return std::ranges::any_of(objects_.rpdo, [](const PdoParams& params) {
    return is_valid(params) && params.event_ms != 0;
  });
}

bool Pdos::on_time() const {
  for (std::size_t i = 0; i < pdo_count; ++i) {
    const PdoParams& params = objects_.rpdo[i];
    if (is_valid(params) && params.event_ms != 0 && (!rx_[i].watched || rx_[i].late)) {
      return false;
    }
  }
  return true;
}

// Sending.

void Pdos::sync(std::uint8_t counter) {
  for (std::size_t i = 0; i < pdo_count; ++i) {
    if (rx_[i].waits) {
      rx_[i].waits = false;
      apply(objects_.rpdo_map[i], rx_[i].data);
    }
  }
  for (std::size_t i = 0; i < pdo_count; ++i) {
    const PdoParams& params = objects_.tpdo[i];
    Transmit& tx = tx_[i];
    if (!is_used(params, objects_.tpdo_map[i]) || first_event_type <= params.type) {
      continue;
    }
    if (params.type == 0) {
      const std::array<std::uint8_t, 8> before = tx.data;
      const std::uint8_t length = tx.length;
      sample(i);
      tx.due = tx.due || !tx.ever || length != tx.length || before != tx.data;
      tx.sampled = tx.due;
      continue;
    }
    if (counter != 0 && params.sync_start != 0 && !tx.started && counter != params.sync_start) {
      continue;
    }
    // The SYNC whose counter is the start value is the first one, and is answered.
    tx.syncs = !tx.started && counter != 0 && params.sync_start != 0
                   ? params.type
                   : static_cast<std::uint8_t>(tx.syncs + 1);
    tx.started = true;
    if (params.type <= tx.syncs) {
      tx.syncs = 0;
      sample(i);
      tx.due = true;
    }
  }
}

/// Takes the values at the SYNC. These are sent even if later frames change the objects before.
void Pdos::sample(std::size_t i) {
  Transmit& tx = tx_[i];
  tx.length = pack(objects_.tpdo_map[i], tx.data);
  tx.sampled = true;
}

PdoEvent Pdos::advance(std::uint64_t now_us) {
  PdoEvent event = PdoEvent::none;
  for (std::size_t i = 0; i < pdo_count; ++i) {
    const PdoParams& params = objects_.rpdo[i];
    Receive& rx = rx_[i];
    if (is_valid(params) && params.event_ms != 0 && rx.watched && !rx.late &&
        has_elapsed(now_us, rx.came_us, 1000ULL * params.event_ms)) {
      rx.late = true;
      event = PdoEvent::timed_out;
    }
    look(i, now_us);
  }
  return event;
}

/// Makes an event-driven PDO due if its data have changed or its event timer has run out.
void Pdos::look(std::size_t i, std::uint64_t now_us) {
  const PdoParams& params = objects_.tpdo[i];
  Transmit& tx = tx_[i];
  if (!is_used(params, objects_.tpdo_map[i]) || params.type < first_event_type || tx.due) {
    return;
  }
  std::array<std::uint8_t, 8> data{};
  const std::uint8_t length = pack(objects_.tpdo_map[i], data);
  const bool by_time =
      params.event_ms != 0 && has_elapsed(now_us, tx.sent_us, 1000ULL * params.event_ms);
  tx.due = !tx.ever || by_time || length != tx.length || data != tx.data;
}

bool Pdos::take(hal::CanFrame& frame, std::uint64_t now_us) {
  for (std::size_t i = 0; i < pdo_count; ++i) {
    const PdoParams& params = objects_.tpdo[i];
    Transmit& tx = tx_[i];
    if (!tx.due || !is_valid(params)) {
      continue;
    }
    const bool inhibited = first_event_type <= params.type && tx.ever &&
                           !has_elapsed(now_us, tx.sent_us, 100ULL * params.inhibit_100us);
    if (inhibited) {
      continue;
    }
    if (!tx.sampled) {
      tx.length = pack(objects_.tpdo_map[i], tx.data);
    }
    tx.sampled = false;
    tx.sent_us = now_us;
    tx.due = false;
    tx.ever = true;
    frame = {};
    frame.id = params.cob & cob_id_mask;
    frame.length = tx.length;
    frame.data = tx.data;
    return true;
  }
  return false;
}

std::uint8_t Pdos::pack(const Mapping& map, std::array<std::uint8_t, 8>& data) {
  data = {};
  std::size_t at = 0;
  for (const std::uint32_t object : objects_of(map)) {
    const std::size_t size = bits_of(object) / 8;
    Entry entry{};
    if (dictionary_.find(key_of(object), entry) == Abort::none) {
      dictionary_.read(entry, 0, std::span(data).subspan(at, size));
    }
    at += size;
  }
  return static_cast<std::uint8_t>(at);
}

}  // namespace smaservo::canopen
