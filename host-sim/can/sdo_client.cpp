#include "host-sim/can/sdo_client.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "firmware/canopen/node/object.hpp"
#include "firmware/text/canopen/abort_text.hpp"

namespace smaservo::can {
namespace {

using canopen::put_number;
using canopen::take_number;

constexpr std::uint32_t request_base = 0x600;
constexpr std::uint32_t answer_base = 0x580;
constexpr std::size_t max_in_segment = 7;

// Bounds that keep a node from occupying its client for ever.
/// The longest value. The longest known one, that of a daemon's recorder, has 256 kB.
constexpr std::size_t max_value = std::size_t{1} << 20U;
/// A node may use its whole time-out for each seven bytes, and this many time-outs in addition; a
/// node that sends its value byte by byte at that pace is given up.
constexpr std::int64_t spare_timeouts = 16;
/// Number of attempts of a read. A write is usually not repeated, because only its answer may have
/// been lost, and a command that heats a wire must never be executed twice.
constexpr int reads = 2;
/// Number of times that a block may bring nothing new before the transfer is given up.
constexpr unsigned max_vain_blocks = 3;

// Command specifiers: the three highest bits of the first byte (CiA 301, 7.2.4.3).
constexpr std::uint8_t start_download = 0x20;
constexpr std::uint8_t start_upload = 0x40;
constexpr std::uint8_t upload_segment = 0x60;
constexpr std::uint8_t aborted = 0x80;
constexpr std::uint8_t upload_answer = 0x40;
constexpr std::uint8_t download_answer = 0x60;
constexpr std::uint8_t segment_answer = 0x20;
constexpr std::uint8_t toggle_bit = 0x10;
constexpr std::uint8_t expedited_bit = 0x02;
constexpr std::uint8_t size_bit = 0x01;
constexpr std::uint8_t last_bit = 0x01;

constexpr std::uint8_t command_of(std::uint8_t byte) {
  return byte & 0xE0U;
}

/// Whether these are the first bytes of an answer that begins another kind of transfer than the one
/// asked for: `request` and `answer` are command specifiers of requests and answers.
bool answers_another(std::uint8_t request, std::uint8_t answer) {
  // The first request and the first answer of each kind: read, write, block read, block write.
  constexpr std::array<std::array<std::uint8_t, 2>, 4> kinds{
      {{0x40, 0x40}, {0x20, 0x60}, {0xA0, 0xC0}, {0xC0, 0xA0}}};
  return std::ranges::any_of(kinds, [&](const auto& kind) {
    return kind[1] == command_of(answer) && kind[0] != command_of(request);
  });
}

std::uint32_t size_in(std::span<const std::uint8_t, 8> data) {
  return static_cast<std::uint32_t>(take_number(data.subspan(4)));
}

}  // namespace

std::string key_text(Key key) {
  return fmt::format("{:04X}h:{}", key.index, key.sub);
}

void SdoClient::send(const Data& data) {
  bus_.send({.id = request_base + node_, .length = 8, .data = data});
}

bool SdoClient::next_answer(Data& data, std::int64_t until_us) {
  hal::CanFrame frame;
  while (bus_.receive(frame, until_us)) {
    if (frame.id == answer_base + node_ && !frame.extended && !frame.remote && frame.length == 8) {
      data = frame.data;
      return true;
    }
    // This ends the loop on a bus that is never quiet, on which there is always another frame.
    if (bus_.now_us() >= until_us) {
      return false;
    }
  }
  return false;
}

SdoClient::Data SdoClient::answer(Key key) {
  Data data{};
  if (!next_answer(data, bus_.now_us() + timeout_us_)) {
    silent(key);
  }
  if (data[0] == aborted) {
    refused(key, size_in(data));
  }
  return data;
}

/// Drops queued frames, which answer transfers that timed out. The number is bounded, because a bus
/// may never be silent.
void SdoClient::drop_old() {
  constexpr int max_queued = 100'000;
  hal::CanFrame old;
  for (int i = 0; i < max_queued && bus_.receive(old, 0); ++i) {
  }
}

/// Sends the first frame of a transfer and returns the answer. Answers for other objects, and those
/// to a request of another kind, are skipped: they belong to earlier transfers that timed out, or
/// to another client.
SdoClient::Data SdoClient::request(Key key, const Data& data, int times) {
  drop_old();
  Data first = data;
  put_number(std::span(first).subspan(1, 2), key.index);
  first[3] = key.sub;
  Data got{};
  for (int i = 0; i < times; ++i) {
    send(first);
    const std::int64_t until_us = bus_.now_us() + timeout_us_;
    while (next_answer(got, until_us)) {
      const bool has_key =
          std::ranges::equal(std::span(got).subspan(1, 3), std::span(first).subspan(1, 3));
      if (!has_key || answers_another(first[0], got[0])) {
        continue;
      }
      if (got[0] == aborted) {
        refused(key, size_in(got));
      }
      return got;
    }
  }
  silent(key, times);
}

void SdoClient::silent(Key key, int times) const {
  throw SdoError(
      fmt::format("node {} on {}: {}: no answer within {} s{}", node_, bus_.name(), key_text(key),
                  static_cast<double>(timeout_us_) * 1e-6, times > 1 ? ", asked twice" : ""),
      0);
}

/// Whether a request is answered twice: then two devices on the bus have this node-id.
bool SdoClient::two_answer() {
  constexpr std::int64_t patience_us = 100'000;
  drop_old();
  const Data request{start_upload, 0x00, 0x10, 0};  // device type
  send(request);
  const std::int64_t until_us = bus_.now_us() + patience_us;
  int answers = 0;
  Data got{};
  while (answers < 2 && next_answer(got, until_us)) {
    const bool is_answer =
        std::ranges::equal(std::span(got).subspan(1, 3), std::span(request).subspan(1, 3));
    answers += is_answer ? 1 : 0;
  }
  return answers == 2;
}

/// A likely cause behind an abort code. A second device with the same node-id disturbs transfers so
/// that either side receives frames of the other's transfer.
std::string SdoClient::cause_of(std::uint32_t code) {
  const bool disturbed = (code & 0xFFFF'0000U) == 0x0503'0000 || code == 0x05040001 ||
                         code == 0x05040003 || code == 0x05040004;
  const std::string_view text = text::abort_text(code);
  if (disturbed && two_answer()) {
    return fmt::format("two devices answer as node {}", node_);
  }
  return std::string(text.empty() ? "unknown reason" : text);
}

void SdoClient::refused(Key key, std::uint32_t code) {
  throw SdoError(fmt::format("node {}: {}: refused: {} (abort {:08X}h)", node_, key_text(key),
                             cause_of(code), code),
                 code);
}

void SdoClient::abort(Key key, std::uint32_t code) {
  Data data{aborted};
  put_number(std::span(data).subspan(1, 2), key.index);
  data[3] = key.sub;
  put_number(std::span(data).subspan(4), code);
  send(data);
  throw SdoError(fmt::format("node {}: {}: broken off: {} (abort {:08X}h)", node_, key_text(key),
                             cause_of(code), code),
                 code);
}

Bytes SdoClient::upload(Key key) {
  const Transfer transfer(*this);
  const Data first = request(key, {start_upload}, reads);
  if (command_of(first[0]) != upload_answer) {
    abort(key, 0x05040001);
  }
  if ((first[0] & expedited_bit) == 0) {
    return receive_segments(key, first);
  }
  const std::size_t unused = (first[0] & size_bit) != 0 ? (first[0] >> 2U) & 3U : 0;
  const auto value = std::span(first).subspan(4, 4 - unused);
  return {value.begin(), value.end()};
}

/// The greatest length of a value: the announced one, if it was announced.
std::size_t SdoClient::expected_size(Key key, bool announced, std::size_t size) {
  if (!announced) {
    return max_value;
  }
  if (size > max_value) {
    abort(key, 0x05040005);
  }
  return size;
}

Bytes SdoClient::receive_segments(Key key, const Data& first) {
  const std::size_t longest = expected_size(key, (first[0] & size_bit) != 0, size_in(first));
  const std::int64_t start_us = bus_.now_us();
  Bytes value;
  std::uint8_t toggle = 0;
  for (bool last = false; !last; toggle ^= toggle_bit) {
    send({static_cast<std::uint8_t>(upload_segment | toggle)});
    const Data data = answer(key);
    if (command_of(data[0]) != 0) {
      abort(key, 0x05040001);
    }
    if ((data[0] & toggle_bit) != toggle) {
      abort(key, 0x05030000);
    }
    const std::size_t unused = (data[0] >> 1U) & 7U;
    const auto part = std::span(data).subspan(1, max_in_segment - unused);
    value.insert(value.end(), part.begin(), part.end());
    last = (data[0] & last_bit) != 0;
    if (value.size() > longest) {
      abort(key, 0x06070012);
    }
    const auto timeouts = spare_timeouts + static_cast<std::int64_t>(value.size() / max_in_segment);
    if (!last && (part.empty() || bus_.now_us() - start_us > timeouts * timeout_us_)) {
      abort(key, 0x05040000);
    }
  }
  if ((first[0] & size_bit) != 0 && size_in(first) != value.size()) {
    abort(key, 0x06070010);
  }
  return value;
}

void SdoClient::write(Key key, std::span<const std::uint8_t> value, int times) {
  if (value.empty() || value.size() > 4) {
    download_segmented(key, value);
    return;
  }
  const Transfer transfer(*this);
  Data data{static_cast<std::uint8_t>(start_download | (4 - value.size()) << 2U | expedited_bit |
                                      size_bit)};
  std::ranges::copy(value, data.begin() + 4);
  if (command_of(request(key, data, times)[0]) != download_answer) {
    abort(key, 0x05040001);
  }
}

void SdoClient::download_segmented(Key key, std::span<const std::uint8_t> value) {
  const Transfer transfer(*this);
  Data data{start_download | size_bit};
  put_number(std::span(data).subspan(4), value.size());
  if (command_of(request(key, data)[0]) != download_answer) {
    abort(key, 0x05040001);
  }
  send_segments(key, value);
}

void SdoClient::send_segments(Key key, std::span<const std::uint8_t> value) {
  std::uint8_t toggle = 0;
  for (bool last = false; !last; toggle ^= toggle_bit) {
    const std::size_t size = std::min(value.size(), max_in_segment);
    last = size == value.size();
    Data data{
        static_cast<std::uint8_t>(toggle | (max_in_segment - size) << 1U | (last ? last_bit : 0U))};
    std::ranges::copy(value.first(size), data.begin() + 1);
    value = value.subspan(size);
    send(data);
    const Data got = answer(key);
    if (command_of(got[0]) != segment_answer) {
      abort(key, 0x05040001);
    }
    if ((got[0] & toggle_bit) != toggle) {
      abort(key, 0x05030000);
    }
  }
}

// Blocks.

namespace {

constexpr std::uint8_t block_upload = 0xA0;    ///< both directions: request, and acknowledgement
constexpr std::uint8_t block_download = 0xC0;  ///< request, and end
constexpr std::uint8_t block_upload_answer = 0xC0;
constexpr std::uint8_t block_download_answer = 0xA0;
constexpr std::uint8_t with_crc = 0x04;
constexpr std::uint8_t with_size = 0x02;
constexpr std::uint8_t part_mask = 0x03;
constexpr std::uint8_t part_end = 1;
constexpr std::uint8_t part_acknowledged = 2;
constexpr std::uint8_t part_start = 3;
constexpr std::uint8_t last_segment = 0x80;
constexpr std::uint8_t max_segments = 127;

}  // namespace

Bytes SdoClient::upload_block(Key key) {
  const Transfer transfer(*this);
  const Data first = request(
      key, {static_cast<std::uint8_t>(block_upload | with_crc), 0, 0, 0, max_segments, 0}, reads);
  if (command_of(first[0]) != block_upload_answer) {
    abort(key, 0x05040001);
  }
  send({block_upload | part_start});
  const std::size_t longest = expected_size(key, (first[0] & with_size) != 0, size_in(first));
  Bytes value;
  receive_blocks(key, value, longest);
  const Data end = answer(key);
  if (command_of(end[0]) != block_upload_answer || (end[0] & part_mask) != part_end) {
    abort(key, 0x05040001);
  }
  value.resize(value.size() - ((end[0] >> 2U) & 7U));
  const bool checked = (first[0] & with_crc) != 0;
  if (checked && take_number(std::span(end).subspan(1, 2)) != canopen::crc16(value)) {
    abort(key, 0x05040004);
  }
  if ((first[0] & with_size) != 0 && size_in(first) != value.size()) {
    abort(key, 0x06070010);
  }
  send({block_upload | part_end});
  return value;
}

/// Appends whole segments to `value`, including the padding of the last one. Lost segments are
/// requested again.
void SdoClient::receive_blocks(Key key, Bytes& value, std::size_t longest) {
  unsigned vain = 0;
  for (bool last = false; !last;) {
    const std::size_t before = value.size();
    unsigned heard = 0;
    const std::uint8_t good = receive_block(key, value, last, heard);
    vain = value.size() > before ? 0 : vain + 1;
    if (vain == max_vain_blocks && heard == 0) {
      silent(key);
    }
    if (vain == max_vain_blocks) {
      abort(key, 0x05040003);
    }
    // The last segment is padded, and an empty value is sent as one segment.
    if (value.size() >= std::max<std::size_t>(longest, 1) + max_in_segment) {
      abort(key, 0x06070012);
    }
    send({static_cast<std::uint8_t>(block_upload | part_acknowledged), good, max_segments});
  }
}

/// Appends the segments of a block up to the first missing one; returns their number.
std::uint8_t SdoClient::receive_block(Key key, Bytes& value, bool& last, unsigned& heard) {
  std::uint8_t good = 0;
  for (Data data{}; heard < max_segments && next_answer(data, bus_.now_us() + timeout_us_);) {
    ++heard;
    if (data[0] == aborted) {
      refused(key, size_in(data));
    }
    const std::uint8_t number = data[0] & static_cast<std::uint8_t>(~last_segment);
    const bool ends = (data[0] & last_segment) != 0;
    if (number == good + 1) {
      good = number;
      value.insert(value.end(), data.begin() + 1, data.end());
      last = ends;
    }
    if (ends || number >= max_segments) {
      break;
    }
  }
  return good;
}

void SdoClient::download_block(Key key, std::span<const std::uint8_t> value) {
  const Transfer transfer(*this);
  Data data{static_cast<std::uint8_t>(block_download | with_crc | with_size)};
  put_number(std::span(data).subspan(4), value.size());
  const Data first = request(key, data);
  if (command_of(first[0]) != block_download_answer) {
    abort(key, 0x05040001);
  }
  if (first[4] == 0 || first[4] > max_segments) {
    abort(key, 0x05040002);
  }
  send_blocks(key, value, first[4]);
  const std::size_t unused = (max_in_segment - value.size() % max_in_segment) % max_in_segment;
  Data end{static_cast<std::uint8_t>(block_download | unused << 2U | part_end)};
  put_number(std::span(end).subspan(1, 2), canopen::crc16(value));
  send(end);
  const Data got = answer(key);
  if (command_of(got[0]) != block_download_answer || (got[0] & part_mask) != part_end) {
    abort(key, 0x05040001);
  }
}

void SdoClient::send_blocks(Key key, std::span<const std::uint8_t> value, unsigned block_size) {
  unsigned vain = 0;
  while (!value.empty()) {
    const std::size_t segments =
        std::min<std::size_t>((value.size() + max_in_segment - 1) / max_in_segment, block_size);
    for (std::size_t i = 0; i < segments; ++i) {
      const auto rest = value.subspan(i * max_in_segment);
      const auto part = rest.first(std::min(rest.size(), max_in_segment));
      const bool last = part.size() == rest.size();
      Data data{static_cast<std::uint8_t>((last ? last_segment : 0U) | (i + 1))};
      std::ranges::copy(part, data.begin() + 1);
      send(data);
    }
    const Data got = answer(key);
    if (command_of(got[0]) != block_download_answer || (got[0] & part_mask) != part_acknowledged ||
        got[1] > segments) {
      abort(key, 0x05040001);
    }
    vain = got[1] > 0 ? 0 : vain + 1;
    if (vain == max_vain_blocks) {
      abort(key, 0x05040003);
    }
    // Segments after the first one that the node missed are sent again.
    value = value.subspan(std::min(value.size(), got[1] * max_in_segment));
    block_size = got[2];
    if (block_size == 0 || block_size > max_segments) {
      abort(key, 0x05040002);
    }
  }
}

}  // namespace smaservo::can
