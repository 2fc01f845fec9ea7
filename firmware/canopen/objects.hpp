#pragma once
// How an object is described: once, with its name, for the EDS, the reference and the node. The
// node itself keeps a copy without texts.

#include <algorithm>
#include <array>
#include <string_view>

#include "firmware/canopen/object.hpp"

namespace smaservo::canopen {

/// One object of up to 4 bytes that lives at an offset of a plain struct; or, at `nowhere`, one
/// that its owner serves by code. Numbers are 32 bits, sign-extended, or a float's.
struct Object {
  Key key;
  Type type;
  std::uint16_t access;
  std::uint16_t at;
  std::uint32_t standard, least, greatest;
};
inline constexpr std::uint16_t nowhere = 0xFFFF;

struct DescribedObject {
  Object object;
  std::string_view name, meaning;
};

/// What EDS and reference call an index with several sub-indices.
struct IndexName {
  std::uint16_t index;
  std::string_view name;
};

constexpr std::uint32_t least_of(Type type) {
  return type == Type::i8     ? as_bits(std::int32_t{-128})
         : type == Type::i16  ? as_bits(std::int32_t{-32768})
         : type == Type::i32  ? 0x8000'0000U
         : type == Type::real ? as_bits(-3.4e38F)
                              : 0;
}
constexpr std::uint32_t greatest_of(Type type) {
  return type == Type::boolean ? 1
         : type == Type::i8    ? 127
         : type == Type::u8    ? 255
         : type == Type::i16   ? 32767
         : type == Type::u16   ? 65535
         : type == Type::i32   ? 0x7FFF'FFFFU
         : type == Type::real  ? as_bits(3.4e38F)
                               : 0xFFFF'FFFFU;
}

/// A row without limits but those of its type.
constexpr DescribedObject row(Key key, Type type, unsigned access, std::size_t at,
                              std::string_view name, std::uint32_t standard = 0,
                              std::string_view meaning = "") {
  return {{key, type, static_cast<std::uint16_t>(access), static_cast<std::uint16_t>(at), standard,
           least_of(type), greatest_of(type)},
          name,
          meaning};
}
/// A row with a range.
constexpr DescribedObject row(Key key, Type type, unsigned access, std::size_t at,
                              std::string_view name, std::uint32_t standard, std::uint32_t least,
                              std::uint32_t greatest, std::string_view meaning = "") {
  return {{key, type, static_cast<std::uint16_t>(access), static_cast<std::uint16_t>(at), standard,
           least, greatest},
          name,
          meaning};
}

template <std::size_t n>
constexpr std::array<Object, n> without_texts(const std::array<DescribedObject, n>& rows) {
  std::array<Object, n> objects{};
  std::ranges::transform(rows, objects.begin(), &DescribedObject::object);
  return objects;
}
constexpr bool in_order(std::span<const DescribedObject> rows) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (!(rows[i - 1].object.key < rows[i].object.key)) {
      return false;
    }
  }
  return true;
}

/// Finds a key in rows that stand in order. A sub-index 0 that has no row of its own says what the
/// highest one is.
Abort find_object(std::span<const Object> rows, Key key, Entry& entry);

/// The entry of "highest sub-index", whoever has it: the number is in the handle.
constexpr Entry highest_sub_entry(Key key, std::uint8_t highest) {
  return {key, Type::u8, readable | constant, static_cast<std::uint16_t>(0xFF00U | highest), 1};
}
constexpr bool is_highest_sub(const Entry& entry) {
  return entry.handle >> 8U == 0xFF;
}

/// Of a row whose value lives in `memory`.
std::uint32_t load(const Object& object, std::span<const std::byte> memory);
void keep(const Object& object, std::span<std::byte> memory, std::uint32_t value);
/// Every default; node-id where it counts.
void reset_objects(std::span<const Object> rows, std::span<std::byte> memory, std::uint8_t node_id);
constexpr std::uint32_t default_of(const Object& object, std::uint8_t node_id) {
  return object.standard + ((object.access & by_node) != 0 ? node_id : 0U);
}

}  // namespace smaservo::canopen
