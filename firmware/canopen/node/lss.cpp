#include "firmware/canopen/node/lss.hpp"

#include <algorithm>
#include <utility>

#include "firmware/canopen/node/object.hpp"

namespace smaservo::canopen {
namespace {

constexpr std::uint8_t global_switch = 0x04;
constexpr std::uint8_t set_node_id = 0x11;
constexpr std::uint8_t set_timing = 0x13;
constexpr std::uint8_t activate_timing = 0x15;
constexpr std::uint8_t store_all = 0x17;
constexpr std::uint8_t select_first = 0x40, select_last = 0x43, selected_answer = 0x44;
constexpr std::uint8_t identify_first = 0x46, identify_last = 0x4B;
constexpr std::uint8_t identify_unconfigured = 0x4C;
constexpr std::uint8_t identified = 0x4F, identified_unconfigured = 0x50;
constexpr std::uint8_t scan = 0x51;
constexpr std::uint8_t inquire_first = 0x5A, inquire_node_id = 0x5E;
constexpr std::uint8_t out_of_range = 1;

std::uint32_t number_at_1(std::span<const std::uint8_t, 8> request) {
  return static_cast<std::uint32_t>(take_number(request.subspan(1, 4)));
}

}  // namespace

void Lss::reset(std::uint8_t node_id, std::uint8_t bit_rate) {
  node_id_ = pending_node_id_ = node_id;
  pending_bit_rate_ = bit_rate;
  selected_ = identified_ = scanned_ = 0;
  scanning_ = configures_ = answer_waits_ = false;
}

LssAction Lss::receive(Request request) {
  const std::uint8_t command = request[0];
  if (command == global_switch) {
    return switch_global(request);
  }
  if (select_first <= command && command <= select_last) {
    select(request);
  } else if (identify_first <= command && command <= identify_last) {
    identify(request);
  } else if (command == identify_unconfigured) {
    if (node_id_ == unconfigured) {
      answer(identified_unconfigured);
    }
  } else if (command == scan) {
    fastscan(request);
  } else if (configures_) {
    return configure(request);
  }
  return LssAction::none;
}

LssAction Lss::configure(Request request) {
  switch (request[0]) {
    case set_node_id: {
      const std::uint8_t id = request[1];
      const bool possible = may_be_node_id(id);
      pending_node_id_ = possible ? id : pending_node_id_;
      answer(set_node_id, possible ? 0 : out_of_range);
      return possible ? LssAction::node_id : LssAction::none;
    }
    case set_timing:
      set_bit_rate(request);
      return LssAction::none;
    case activate_timing:
      delay_ms_ = static_cast<std::uint16_t>(take_number(request.subspan(1, 2)));
      return bit_rates_ == 0 ? LssAction::none : LssAction::activate;
    case store_all:
      return LssAction::store;
    default:
      inquire(request[0]);
      return LssAction::none;
  }
}

/// Begins or ends a configuration. When it ends, a node without a node-id may start with the new
/// one.
LssAction Lss::switch_global(Request request) {
  const bool begins = request[1] == 1;
  const bool ended = configures_ && request[1] == 0;
  if (request[1] <= 1) {
    configures_ = begins;
    selected_ = identified_ = 0;
    scanning_ = false;
  }
  return ended && node_id_ == unconfigured && pending_node_id_ != unconfigured ? LssAction::node_id
                                                                               : LssAction::none;
}

/// The parts come in this order: vendor, product, revision, serial number.
void Lss::select(Request request) {
  const auto part = static_cast<std::size_t>(request[0] - select_first);
  const auto before = static_cast<std::uint8_t>((1U << part) - 1U);
  const bool matches = number_at_1(request) == identity_[part] && (selected_ & before) == before;
  selected_ = matches ? static_cast<std::uint8_t>(before | 1U << part) : std::uint8_t{0};
  if (selected_ == 0xF) {
    selected_ = 0;
    configures_ = true;
    answer(selected_answer);
  }
}

/// The parts come in this order: vendor, product, min and max revision, min and max serial number.
void Lss::identify(Request request) {
  const auto step = static_cast<unsigned>(request[0] - identify_first);
  constexpr std::array<std::uint8_t, 6> part{0, 1, 2, 2, 3, 3};
  const std::uint32_t own = identity_[part[step]];
  const std::uint32_t asked = number_at_1(request);
  const bool matches = step < 2 ? asked == own : step % 2 == 0 ? asked <= own : own <= asked;
  const auto before = static_cast<std::uint8_t>((1U << step) - 1U);
  identified_ = matches && (identified_ & before) == before
                    ? static_cast<std::uint8_t>(before | 1U << step)
                    : std::uint8_t{0};
  if (identified_ == 0x3F) {
    identified_ = 0;
    answer(identified);
  }
}

/// Nodes without a node-id are found bit by bit: a node answers if this part of its identity agrees
/// with the request from the highest bit down to `bit`.
void Lss::fastscan(Request request) {
  if (node_id_ != unconfigured || configures_) {
    return;
  }
  constexpr std::uint8_t begin = 0x80;
  const std::uint8_t bit = request[5], part = request[6], next = request[7];
  if (bit == begin) {
    scanning_ = true;
    scanned_ = 0;
    answer(identified);
    return;
  }
  if (!scanning_ || bit > 31 || part > 3 || next > 3 || part != scanned_) {
    return;
  }
  if (number_at_1(request) >> bit != identity_[part] >> bit) {
    return;
  }
  if (bit == 0) {
    scanned_ = next;
    if (next < part) {
      scanning_ = false;
      configures_ = true;
    }
  }
  answer(identified);
}

void Lss::set_bit_rate(Request request) {
  constexpr std::uint8_t cia_table = 0;
  const std::uint8_t table = request[1], rate = request[2];
  const bool possible = table == cia_table && rate < 16 && (bit_rates_ >> rate & 1U) != 0;
  pending_bit_rate_ = possible ? rate : pending_bit_rate_;
  answer(set_timing, possible ? 0 : out_of_range);
}

void Lss::inquire(std::uint8_t command) {
  if (inquire_first <= command && command < inquire_node_id) {
    answer(command, identity_[command - inquire_first]);
  } else if (command == inquire_node_id) {
    answer(command, node_id_);
  }
}

void Lss::finish_store(bool done) {
  constexpr std::uint8_t media_error = 2;
  answer(store_all, done ? 0 : media_error);
}

void Lss::answer(std::uint8_t command, std::uint32_t value) {
  answer_ = {command};
  put_number(std::span(answer_).subspan(1, 4), value);
  answer_waits_ = true;
}

bool Lss::take(std::span<std::uint8_t, 8> answer) {
  if (answer_waits_) {
    std::ranges::copy(answer_, answer.begin());
  }
  return std::exchange(answer_waits_, false);
}

}  // namespace smaservo::canopen
