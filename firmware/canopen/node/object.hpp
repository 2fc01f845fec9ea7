#pragma once
// Objects of a CANopen node as its services see them, independent of who holds their values.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/parameters/key.hpp"

namespace smaservo::canopen {

/// The numbers are those of CiA 301's data types.
enum class Type : std::uint8_t {
  none = 0,
  boolean = 0x01,
  i8 = 0x02,
  i16 = 0x03,
  i32 = 0x04,
  u8 = 0x05,
  u16 = 0x06,
  u32 = 0x07,
  real = 0x08,
  text = 0x09,
  octets = 0x0A,
  domain = 0x0F,
  f64 = 0x11,
  i64 = 0x15,
  u64 = 0x1B,
};

/// Bytes of a value; 0 if the length varies.
constexpr std::uint32_t size_of(Type type) {
  switch (type) {
    case Type::boolean:
    case Type::i8:
    case Type::u8:
      return 1;
    case Type::i16:
    case Type::u16:
      return 2;
    case Type::i32:
    case Type::u32:
    case Type::real:
      return 4;
    case Type::f64:
    case Type::i64:
    case Type::u64:
      return 8;
    case Type::none:
    case Type::text:
    case Type::octets:
    case Type::domain:
      break;
  }
  return 0;
}
constexpr bool is_signed(Type type) {
  return type == Type::i8 || type == Type::i16 || type == Type::i32 || type == Type::i64;
}

// Access flags of an object; bits.
inline constexpr std::uint16_t readable = 1;
inline constexpr std::uint16_t writable = 2;
inline constexpr std::uint16_t in_rpdo = 4;   ///< may be written by a PDO
inline constexpr std::uint16_t in_tpdo = 8;   ///< may be sent in a PDO
inline constexpr std::uint16_t stored = 16;   ///< stored by 1010h, in the node's image
inline constexpr std::uint16_t by_node = 32;  ///< its default is increased by the node-id
inline constexpr std::uint16_t constant = 64;
inline constexpr std::uint16_t needs_tune = 128;    ///< Level::tune
inline constexpr std::uint16_t needs_set_up = 256;  ///< Level::set_up

// Levels needed to write an object, by its possible effect on the heat. Tables use these constants,
// never `writable` alone.
/// For set-points within the limits, states that end or keep heat, and objects that only concern
/// measuring or reporting.
inline constexpr std::uint16_t operated = writable;
/// For the way a set-point is approached, and power that does not come from a loop of the device.
inline constexpr std::uint16_t tuned = writable | needs_tune;
/// For bounds of heat or motion, and for conditions that end the heat: a fault, a stop, or loss of
/// the command source.
inline constexpr std::uint16_t set_up = writable | needs_set_up;

constexpr std::uint16_t written_at(Level level) {
  return level == Level::set_up ? set_up : level == Level::tune ? tuned : operated;
}
constexpr Level level_of(std::uint16_t access) {
  return (access & needs_set_up) != 0 ? Level::set_up
         : (access & needs_tune) != 0 ? Level::tune
                                      : Level::operate;
}

/// The reason why a transfer has failed: CiA 301's SDO abort codes.
enum class Abort : std::uint32_t {
  none = 0,
  pending = 1,  ///< no abort code: the answer comes later
  toggle = 0x05030000,
  timeout = 0x05040000,
  command = 0x05040001,
  block_size = 0x05040002,
  sequence = 0x05040003,
  crc = 0x05040004,
  memory = 0x05040005,
  write_only = 0x06010001,
  read_only = 0x06010002,
  no_object = 0x06020000,
  not_mappable = 0x06040041,
  pdo_length = 0x06040042,
  incompatible = 0x06040043,
  hardware = 0x06060000,
  too_long = 0x06070012,
  too_short = 0x06070013,
  no_sub = 0x06090011,
  value = 0x06090030,
  too_high = 0x06090031,
  too_low = 0x06090032,
  max_below_min = 0x06090036,
  transfer = 0x08000020,
  local = 0x08000021,  ///< prevented by local control: the access level does not allow it
  state = 0x08000022,  ///< prevented by the present state of the device
  no_data = 0x08000024,
};

/// The origin of a write.
enum class Source : std::uint8_t { sdo, rpdo, lss, device, image, file };

/// An object that was found. `handle` is meaningful only for the dictionary that found it.
struct Entry {
  Key key;
  Type type;
  std::uint16_t access;
  std::uint16_t handle;
  std::uint32_t size;  ///< present size in bytes
};

/// A dictionary of objects: find() gives an Entry by which the object is read and written.
class Dictionary {
 public:
  /// Abort::none, no_object or no_sub.
  virtual Abort find(Key key, Entry& entry) const = 0;
  /// Fills `to` with the value's bytes from `offset` on; all of them are within the entry's size.
  virtual Abort read(const Entry& entry, std::uint32_t offset, std::span<std::uint8_t> to) = 0;
  /// Writes a whole value, whose length fits the type. Checks range and state; a refused value
  /// changes nothing.
  virtual Abort write(const Entry& entry, std::span<const std::uint8_t> from, Source source) = 0;
  /// Called when a client's write was refused before write(): for its length, a wrong checksum, or
  /// because the object is read-only. `from` is the part of the value that is known.
  virtual void refused(const Entry& /*entry*/, std::span<const std::uint8_t> /*from*/,
                       Abort /*why*/) {}

 protected:
  ~Dictionary() = default;
};

// Little-endian numbers of any length up to 8.

constexpr std::uint64_t take_number(std::span<const std::uint8_t> from) {
  std::uint64_t value = 0;
  for (std::size_t i = from.size(); i-- > 0;) {
    value = value << 8U | from[i];
  }
  return value;
}
constexpr void put_number(std::span<std::uint8_t> to, std::uint64_t value) {
  for (std::uint8_t& byte : to) {
    byte = static_cast<std::uint8_t>(value);
    value >>= 8U;
  }
}
constexpr float as_real(std::uint32_t bits) {
  return std::bit_cast<float>(bits);
}
constexpr std::uint32_t as_bits(float value) {
  return std::bit_cast<std::uint32_t>(value);
}
constexpr std::uint32_t as_bits(std::int32_t value) {
  return static_cast<std::uint32_t>(value);
}

/// CRC-16/XMODEM, as used by block transfers; continues from `crc`.
constexpr std::uint16_t crc16(std::span<const std::uint8_t> bytes, std::uint16_t crc = 0) {
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>(crc ^ static_cast<unsigned>(byte) << 8U);
    for (int bit = 0; bit < 8; ++bit) {
      const unsigned shifted = static_cast<unsigned>(crc) << 1U;
      crc = static_cast<std::uint16_t>((crc & 0x8000U) != 0 ? shifted ^ 0x1021U : shifted);
    }
  }
  return crc;
}

/// Compares a value with a range; Abort::none if it is inside. All are 32 bits as sent,
/// sign-extended.
constexpr Abort check_range(Type type, std::uint32_t value, std::uint32_t min, std::uint32_t max) {
  if (type == Type::real) {
    constexpr std::uint32_t exponent = 0x7F80'0000;  // all exponent bits set: infinite or NaN
    const float x = as_real(value);
    return (value & exponent) == exponent ? Abort::value
           : x < as_real(min)             ? Abort::too_low
           : as_real(max) < x             ? Abort::too_high
                                          : Abort::none;
  }
  if (is_signed(type)) {
    const auto x = static_cast<std::int32_t>(value);
    const auto low = static_cast<std::int32_t>(min);
    const auto high = static_cast<std::int32_t>(max);
    return x < low ? Abort::too_low : high < x ? Abort::too_high : Abort::none;
  }
  return value < min ? Abort::too_low : max < value ? Abort::too_high : Abort::none;
}

/// The value of a type of up to 4 bytes as 32 bits, sign-extended.
constexpr std::uint32_t take_value(Type type, std::span<const std::uint8_t> from) {
  const auto bits = static_cast<std::uint32_t>(take_number(from));
  if (is_signed(type) && from.size() < 4) {
    const unsigned shift = 32U - 8U * static_cast<unsigned>(from.size());
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(bits << shift) >>
                                      static_cast<int>(shift));
  }
  return bits;
}

}  // namespace smaservo::canopen
