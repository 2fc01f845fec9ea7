#pragma once
// A stored image of settings, bit by bit. All numbers are little-endian.
//
//   0  "SMAS"
//   4  u16 format, 1          6  u16 number of entries
//   8  u32 sequence          12  u32 schema hash of the writer
//  16  entries of 8 bytes: u16 index, u8 sub-index, u8 type, u32 bits of the value
//   .  u32 CRC-32 (IEEE 802.3) of all bytes before it

#include <algorithm>
#include <array>
#include <bitset>
#include <cstddef>
#include <span>

#include "firmware/parameters/parameter_check.hpp"
#include "firmware/parameters/schemas.hpp"

namespace smaservo {

/// The parameters that an image is written from and read into, and their history. Tests use other
/// tables.
template <class S>
struct StoreSchema {
  std::span<const ParameterRow<S>> rows;
  std::span<const Moved> moved;
};
template <class S>
inline constexpr StoreSchema<S> own_schema{parameter_rows<S>, moved_parameters};

class Crc32 {
 public:
  constexpr void add(std::span<const std::byte> bytes) {
    for (const std::byte byte : bytes) {
      crc_ ^= static_cast<std::uint32_t>(byte);
      // Reflected polynomial 04C11DB7h, four bits at a time.
      crc_ = (crc_ >> 4U) ^ nibbles[crc_ & 15U];
      crc_ = (crc_ >> 4U) ^ nibbles[crc_ & 15U];
    }
  }
  constexpr std::uint32_t value() const { return ~crc_; }

 private:
  static constexpr auto nibbles = [] {
    std::array<std::uint32_t, 16> table{};
    for (std::uint32_t i = 0; i < 16; ++i) {
      std::uint32_t crc = i;
      for (int bit = 0; bit < 4; ++bit) {
        crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
      }
      table[i] = crc;
    }
    return table;
  }();
  std::uint32_t crc_ = 0xFFFFFFFF;
};

namespace image {

inline constexpr std::uint32_t magic = 0x53414D53;  // "SMAS"
inline constexpr std::uint16_t format = 1;
inline constexpr std::uint16_t max_entries = 4096;
inline constexpr std::size_t header_size = 16;
inline constexpr std::size_t entry_size = 8;
inline constexpr std::size_t crc_size = 4;
inline constexpr std::size_t chunk_size = 64;

struct Header {
  std::uint32_t magic;
  std::uint16_t format, entries;
  std::uint32_t sequence, schema_hash;
};

template <class T>
constexpr void put(std::span<std::byte> to, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    to[i] = static_cast<std::byte>(value >> (8 * i));
  }
}
template <class T>
constexpr T take(std::span<const std::byte> from) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value = static_cast<T>(value | (static_cast<T>(from[i]) << (8 * i)));
  }
  return value;
}

constexpr Header take_header(std::span<const std::byte, header_size> from) {
  return {take<std::uint32_t>(from), take<std::uint16_t>(from.subspan(4)),
          take<std::uint16_t>(from.subspan(6)), take<std::uint32_t>(from.subspan(8)),
          take<std::uint32_t>(from.subspan(12))};
}

struct Entry {
  Key key;
  ValueType type;
  Value value;
};

constexpr Entry take_entry(std::span<const std::byte, entry_size> from) {
  return {{take<std::uint16_t>(from), take<std::uint8_t>(from.subspan(2))},
          static_cast<ValueType>(take<std::uint8_t>(from.subspan(3))),
          {take<std::uint32_t>(from.subspan(4))}};
}

/// Collects bytes into chunks for `sink(span) -> bool`.
template <class Sink>
class Writer {
 public:
  explicit Writer(Sink& sink) : sink_(sink) {}

  template <class T>
  void add(T value) {
    std::array<std::byte, sizeof(T)> bytes{};
    put<T>(bytes, value);
    for (const std::byte byte : bytes) {
      chunk_[size_++] = byte;
      if (size_ == chunk_.size()) {
        flush();
      }
    }
  }
  /// Appends the CRC. Returns whether the sink has accepted everything.
  bool finish() {
    flush();
    add(crc_.value());
    flush();
    return ok_;
  }

 private:
  void flush() {
    const std::span<const std::byte> full = std::span(chunk_).first(size_);
    crc_.add(full);
    ok_ = ok_ && (full.empty() || sink_(full));
    size_ = 0;
  }

  Sink& sink_;
  std::array<std::byte, chunk_size> chunk_{};
  std::size_t size_ = 0;
  Crc32 crc_;
  bool ok_ = true;
};

/// Passes the image to the sink in pieces; false if it refuses one.
template <class S, class Sink>
bool write(const StoreSchema<S>& schema, const Settings<S>& settings, std::uint32_t sequence,
           Sink sink) {
  Writer<Sink> out(sink);
  out.template add<std::uint32_t>(magic);
  out.template add<std::uint16_t>(format);
  out.template add<std::uint16_t>(
      static_cast<std::uint16_t>(schema.rows.size() + schema.moved.size()));
  out.template add<std::uint32_t>(sequence);
  out.template add<std::uint32_t>(schema_hash(schema.rows));
  const auto entry = [&](Key key, ValueType type, Value value) {
    out.template add<std::uint16_t>(key.index);
    out.template add<std::uint8_t>(key.sub);
    out.template add<std::uint8_t>(static_cast<std::uint8_t>(type));
    out.template add<std::uint32_t>(value.bits);
  };
  for (const ParameterRow<S>& row : schema.rows) {
    entry(row.key, row.type, row.get(settings));
  }
  for (const Moved& row : schema.moved) {
    const ParameterRow<S>& now = *find_row(schema.rows, row.to);
    const Value value = now.get(settings);
    entry(row.from, now.type,
          now.type == ValueType::real ? Value::real(value.real() / row.factor) : value);
  }
  return out.finish();
}

/// Makes settings from the entries of an image, with defaults for missing entries.
template <class S>
class Reader {
 public:
  explicit Reader(const StoreSchema<S>& schema)
      : schema_(schema), settings_(default_settings<S>()) {}

  void add(std::span<const std::byte, entry_size> bytes) {
    const auto [key, type, value] = take_entry(bytes);
    if (const ParameterRow<S>* row = find_row(schema_.rows, key);
        row != nullptr && row->type == type) {
      set(*row, value);
      own_.set(position(*row));
      return;
    }
    for (const Moved& old : schema_.moved) {
      if (old.from == key) {
        take_moved(old, type, value);
        return;
      }
    }
    ++unknown_;
  }

  const Settings<S>& settings() const { return settings_; }
  std::uint16_t unknown() const { return unknown_; }
  std::uint16_t moved() const { return static_cast<std::uint16_t>((from_moved_ & ~own_).count()); }
  /// The number of parameters that have kept their default.
  std::uint16_t missing() const {
    return static_cast<std::uint16_t>(schema_.rows.size() - (own_ | from_moved_).count());
  }
  Finding finding() const { return finding_.ok() ? check(settings_) : finding_; }

 private:
  std::size_t position(const ParameterRow<S>& row) const {
    return static_cast<std::size_t>(&row - schema_.rows.data());
  }
  void set(const ParameterRow<S>& row, Value value) {
    // Reals are checked together in finding(), because whether one is used depends on others.
    const Fit inside = row.type == ValueType::real ? Fit::inside : fit(row, value);
    if (inside == Fit::inside) {
      row.set(settings_, value);
    } else if (finding_.ok()) {
      finding_ = {problem_of(inside), position(row)};
    }
  }
  /// Takes the value of an old key, unless there is an entry under the parameter's own key, before
  /// or after this one.
  void take_moved(const Moved& old, ValueType type, Value value) {
    const ParameterRow<S>* row = find_row(schema_.rows, old.to);
    if (row == nullptr || row->type != type) {
      ++unknown_;
    } else if (!own_.test(position(*row))) {
      set(*row, type == ValueType::real ? Value::real(old.factor * value.real()) : value);
      from_moved_.set(position(*row));
    }
  }

  static constexpr std::size_t max_rows = 512;
  static_assert(parameter_count <= max_rows);

  const StoreSchema<S>& schema_;
  Settings<S> settings_;
  std::bitset<max_rows> own_, from_moved_;
  std::uint16_t unknown_ = 0;
  Finding finding_;
};

}  // namespace image

}  // namespace smaservo
