#include "host-sim/page/servos/traffic/sync_stream.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "firmware/canopen/node/index.hpp"
#include "firmware/canopen/node/object.hpp"
#include "firmware/text/signal_names.hpp"
#include "model/files/error.hpp"

namespace smaservo::page {
namespace {

namespace index = canopen::index;

using canopen::put_number;
using canopen::take_number;

constexpr std::uint32_t sync_id = 0x80;
constexpr std::uint32_t not_valid = 0x8000'0000;
constexpr std::uint32_t id_mask = 0x7FF;
constexpr std::size_t signals_per_pdo = 2;
constexpr std::size_t most_signals = 8;
/// Order in which the PDOs are used. TPDO1 is last, because other masters read its statusword and
/// faults.
constexpr unsigned pdo_order[] = {2, 3, 4, 1};
/// Number of samples after which missing ones are counted: the answers to some SYNCs may always be
/// still to come.
constexpr unsigned judged_samples = 50;

std::uint16_t index_of(std::uint16_t base, unsigned pdo) {
  return static_cast<std::uint16_t>(base + pdo - 1);
}

std::uint32_t read_whole(can::Remote& remote, Key key) {
  return static_cast<std::uint32_t>(take_number(remote.client().upload(key)));
}

void write_whole(can::Remote& remote, Key key, std::uint32_t value, std::size_t size) {
  can::Bytes bytes(size);
  put_number(bytes, value);
  remote.client().download(key, bytes);
}

/// Length in bytes of an object that describes a PDO.
std::size_t size_of_pdo_object(Key key) {
  const bool whole = (key.index < index::tpdo_mapping && key.sub == 1) ||
                     (key.index >= index::tpdo_mapping && key.sub != 0);
  return whole ? 4 : key.index < index::tpdo_mapping && (key.sub == 3 || key.sub == 5) ? 2 : 1;
}

}  // namespace

SyncStream::SyncStream(double period_s, const std::vector<std::string>& signals)
    : period_us_(std::lround(period_s * 1e6)) {
  if (period_us_ != 0 && !(period_s >= 0.0005 && period_s <= 1)) {
    throw files::UserError(fmt::format("--sync {}: must be 0.0005 to 1 s", period_s));
  }
  if (signals.size() > most_signals) {
    throw files::UserError(
        fmt::format("{} signals by SYNC: must be at most {}", signals.size(), most_signals));
  }
  for (const std::string& name : signals) {
    const std::size_t row = text::signal_row(name);
    if (has_[row]) {
      throw files::UserError(fmt::format("{}: named twice", name));
    }
    order_.push_back(row);
    has_.set(row);
  }
}

std::vector<unsigned> SyncStream::mapped() const {
  std::vector<unsigned> all;
  all.reserve(nodes_.size());
  for (const auto& [node, state] : nodes_) {
    all.push_back(node);
  }
  return all;
}

/// Reads the present configuration of a PDO, in the order in which it can be written again: not
/// valid, no objects, the objects, their number, type and timers, valid.
SyncStream::Pdo SyncStream::read_pdo(can::Remote& remote, unsigned number) {
  const std::uint16_t params = index_of(index::tpdo_communication, number);
  const std::uint16_t map = index_of(index::tpdo_mapping, number);
  const std::uint32_t cob = read_whole(remote, {params, 1});
  const std::uint32_t count = read_whole(remote, {map, 0});
  Pdo pdo{number, cob & id_mask, {{{params, 1}, cob | not_valid}, {{map, 0}, 0}}};
  for (std::uint8_t sub = 1; sub <= std::min(count, 8U); ++sub) {
    pdo.before.push_back({{map, sub}, read_whole(remote, {map, sub})});
  }
  pdo.before.push_back({{map, 0}, count});
  for (const std::uint8_t sub : std::to_array<std::uint8_t>({2, 3, 5})) {
    pdo.before.push_back({{params, sub}, read_whole(remote, {params, sub})});
  }
  pdo.before.push_back({{params, 1}, cob});
  return pdo;
}

void SyncStream::write_pdo(can::Remote& remote, const Pdo& pdo, std::size_t first) const {
  const std::uint16_t params = index_of(index::tpdo_communication, pdo.number);
  const std::uint16_t map = index_of(index::tpdo_mapping, pdo.number);
  const std::uint32_t cob = pdo.before.front().second;
  write_whole(remote, {params, 1}, cob | not_valid, 4);
  write_whole(remote, {map, 0}, 0, 1);
  const std::size_t count = std::min(signals_per_pdo, order_.size() - first);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t object = static_cast<std::uint32_t>(live_values) << 16U |
                                 static_cast<std::uint32_t>(sub_of(order_[first + i])) << 8U | 32U;
    write_whole(remote, {map, static_cast<std::uint8_t>(i + 1)}, object, 4);
  }
  write_whole(remote, {map, 0}, static_cast<std::uint32_t>(count), 1);
  write_whole(remote, {params, 2}, 1, 1);  // at each SYNC
  write_whole(remote, {params, 3}, 0, 2);
  write_whole(remote, {params, 5}, 0, 2);
  write_whole(remote, {params, 1}, cob & ~not_valid, 4);
}

void SyncStream::map(can::Remote& remote) {
  if (read_whole(remote, {index::sync_overflow, 0}) != 0 ||
      (read_whole(remote, {index::sync_cob_id, 0}) & id_mask) != sync_id) {
    throw files::UserError(
        fmt::format("node {}: its SYNC has a counter or another identifier than 80h; live values "
                    "are polled",
                    remote.node()));
  }
  Node node;
  const std::size_t pdos = (order_.size() + signals_per_pdo - 1) / signals_per_pdo;
  for (std::size_t i = 0; i < pdos; ++i) {
    node.pdos.push_back(read_pdo(remote, pdo_order[i]));
  }
  nodes_[remote.node()] = node;
  for (std::size_t i = 0; i < pdos; ++i) {
    write_pdo(remote, node.pdos[i], i * signals_per_pdo);
  }
  remote.nmt(can::NmtCommand::start);
  // Samples that were sent before all PDOs were mapped do not count.
  nodes_[remote.node()] = std::move(node);
}

void SyncStream::put_back(can::Remote& remote) {
  const auto found = nodes_.find(remote.node());
  if (found == nodes_.end()) {
    return;
  }
  const std::vector<Pdo> pdos = found->second.pdos;
  nodes_.erase(found);
  for (const Pdo& pdo : pdos) {
    for (const auto& [key, value] : pdo.before) {
      write_whole(remote, key, value, size_of_pdo_object(key));
    }
  }
}

std::int64_t SyncStream::tick(can::Bus& bus, std::int64_t now_us) {
  if (!wanted() || nodes_.empty() || is_foreign(now_us)) {
    due_us_ = now_us;
    return now_us + 1'000'000;
  }
  if (now_us < due_us_) {
    return due_us_;
  }
  // A SYNC whose time has passed is left out, and its samples count as missing.
  const std::int64_t passed = (now_us - due_us_) / period_us_;
  due_us_ += (passed + 1) * period_us_;
  for (auto& [number, node] : nodes_) {
    node.sent += passed + 1;
  }
  bus.send({.id = sync_id, .length = 0, .data = {}});
  return due_us_;
}

bool SyncStream::heard(const hal::CanFrame& frame, std::int64_t now_us, unsigned& node,
                       Sample& sample) {
  for (auto& [number, state] : nodes_) {
    const auto found = std::ranges::find(state.pdos, frame.id, &Pdo::cob_id);
    if (found == state.pdos.end()) {
      continue;
    }
    const auto place = static_cast<std::size_t>(found - state.pdos.begin());
    // PDOs come in the order of their numbers. If one comes again before all others have come, the
    // rest of the sample before is lost.
    if ((state.filled >> place & 1U) != 0) {
      state.filled = 0;
    }
    if (state.filled == 0) {
      state.sample = {};
    }
    state.filled |= std::size_t{1} << place;
    for (std::size_t i = 0; i < frame.length / 4U; ++i) {
      const std::size_t at = place * signals_per_pdo + i;
      if (at >= order_.size()) {
        break;
      }
      state.sample.has.set(order_[at]);
      state.sample.values[order_[at]] = canopen::as_real(
          static_cast<std::uint32_t>(take_number(std::span(frame.data).subspan(4 * i, 4))));
    }
    if (state.filled + 1 != std::size_t{1} << state.pdos.size()) {
      return false;
    }
    node = number;
    sample = state.sample;
    sample.time_us = now_us;
    state.filled = 0;
    ++state.complete;
    judge_gaps(state);
    return sample.has == has_;
  }
  return false;
}

/// Counts lost samples. If the sample of a SYNC has not come, it is late or lost. The number of
/// late samples varies, so the least number of late and lost ones together is that of the lost
/// ones.
void SyncStream::judge_gaps(Node& node) {
  const std::int64_t open = node.sent - node.complete - node.missing;
  node.fewest_open = node.judged == 0 ? open : std::min(node.fewest_open, open);
  if (++node.judged < judged_samples) {
    return;
  }
  node.missing = std::max<std::int64_t>(node.missing + node.fewest_open, 0);
  node.judged = 0;
}

std::uint64_t SyncStream::gaps(unsigned node) const {
  const auto found = nodes_.find(node);
  return found == nodes_.end() ? 0 : static_cast<std::uint64_t>(found->second.missing);
}

}  // namespace smaservo::page
