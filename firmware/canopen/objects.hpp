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
  if (type == Type::real) {
    return as_bits(-3.4e38F);
  }
  return is_signed(type) ? ~0U << (8 * size_of(type) - 1) : 0;
}
constexpr std::uint32_t greatest_of(Type type) {
  if (type == Type::real) {
    return as_bits(3.4e38F);
  }
  if (type == Type::boolean) {
    return 1;
  }
  const std::uint32_t size = size_of(type) == 0 ? 4 : size_of(type);
  const std::uint32_t all = ~0U >> (32 - 8 * size);
  return is_signed(type) ? all >> 1U : all;
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

/// The entry of "highest sub-index", whoever has it: the number is in the handle.
constexpr Entry highest_sub_entry(Key key, std::uint8_t highest) {
  return {key, Type::u8, readable | constant, static_cast<std::uint16_t>(0xFF00U | highest), 1};
}
constexpr bool is_highest_sub(const Entry& entry) {
  return entry.handle >> 8U == 0xFF;
}

/// Finds a key in rows that stand in the order of their keys; the handle is the row's number. A
/// sub-index 0 that has no row of its own says what the highest one is.
template <class Row>
Abort find_row(std::span<const Row> rows, Key key, Entry& entry, Type (*type_of)(const Row&),
               std::uint16_t (*access_of)(const Row&)) {
  const auto at = std::ranges::lower_bound(rows, key, {}, &Row::key);
  if (at != rows.end() && at->key == key) {
    const Type type = type_of(*at);
    entry = {key, type, access_of(*at), static_cast<std::uint16_t>(at - rows.begin()),
             size_of(type)};
    return Abort::none;
  }
  // Rows of the same index stand beside the place where this one would be.
  const bool before = at != rows.begin() && (at - 1)->key.index == key.index;
  const bool after = at != rows.end() && at->key.index == key.index;
  if (!before && !after) {
    return Abort::no_object;
  }
  if (key.sub != 0) {
    return Abort::no_sub;
  }
  auto last = at;
  while (last + 1 != rows.end() && (last + 1)->key.index == key.index) {
    ++last;
  }
  entry = highest_sub_entry(key, last->key.sub);
  return Abort::none;
}
Abort find_object(std::span<const Object> rows, Key key, Entry& entry);

/// Of a row whose value lives in `memory`.
std::uint32_t load(const Object& object, std::span<const std::byte> memory);
void keep(const Object& object, std::span<std::byte> memory, std::uint32_t value);
/// Every default; node-id where it counts.
void reset_objects(std::span<const Object> rows, std::span<std::byte> memory, std::uint8_t node_id);
constexpr std::uint32_t default_of(const Object& object, std::uint8_t node_id) {
  return object.standard + ((object.access & by_node) != 0 ? node_id : 0U);
}

}  // namespace smaservo::canopen
