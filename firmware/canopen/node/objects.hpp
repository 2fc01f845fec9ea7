#pragma once
// The description of an object, written once with its name, for the EDS, the reference and the
// node. The node itself keeps a copy without texts.

#include <algorithm>
#include <array>
#include <string_view>

#include "firmware/canopen/node/object.hpp"

namespace smaservo::canopen {

/// An object of up to 4 bytes that lives at an offset of a plain struct; at the offset `nowhere`,
/// an object that its owner handles by code. Numbers are 32 bits: sign-extended integers, or the
/// bits of a float.
struct Object {
  Key key;
  Type type;
  std::uint16_t access;
  std::uint16_t at;
  std::uint32_t standard, min, max;
};
inline constexpr std::uint16_t nowhere = 0xFFFF;

struct DescribedObject {
  Object object;
  std::string_view name, meaning;
};

/// The name of an index with several sub-indices in EDS and reference.
struct IndexName {
  std::uint16_t index;
  std::string_view name;
};

constexpr std::uint32_t min_of(Type type) {
  if (type == Type::real) {
    return as_bits(-3.4e38F);
  }
  return is_signed(type) ? ~0U << (8 * size_of(type) - 1) : 0;
}
constexpr std::uint32_t max_of(Type type) {
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

/// A row limited only by the range of its type.
constexpr DescribedObject row(Key key, Type type, unsigned access, std::size_t at,
                              std::string_view name, std::uint32_t standard = 0,
                              std::string_view meaning = "") {
  return {{key, type, static_cast<std::uint16_t>(access), static_cast<std::uint16_t>(at), standard,
           min_of(type), max_of(type)},
          name,
          meaning};
}
/// A row with a range.
constexpr DescribedObject row(Key key, Type type, unsigned access, std::size_t at,
                              std::string_view name, std::uint32_t standard, std::uint32_t min,
                              std::uint32_t max, std::string_view meaning = "") {
  return {{key, type, static_cast<std::uint16_t>(access), static_cast<std::uint16_t>(at), standard,
           min, max},
          name,
          meaning};
}

/// A row in the few bytes that a node keeps: `range` is an index into a table of ranges.
struct ObjectRow {
  std::uint16_t index;
  std::uint8_t sub;
  Type type;
  std::uint16_t access : 9;
  std::uint16_t range : 7;
  std::uint16_t at;
  std::uint32_t standard;
};
struct ObjectRange {
  std::uint32_t min, max;
  friend constexpr bool operator==(const ObjectRange&, const ObjectRange&) = default;
};

/// Rows in the order of their keys; operator[] makes an Object of one.
class ObjectRows {
 public:
  constexpr ObjectRows() = default;
  constexpr ObjectRows(std::span<const ObjectRow> rows, const ObjectRange* ranges)
      : rows_(rows), ranges_(ranges) {}

  std::size_t size() const { return rows_.size(); }
  Object operator[](std::size_t i) const;
  Key key(std::size_t i) const { return {rows_[i].index, rows_[i].sub}; }
  /// The row of a key; size() if there is none.
  std::size_t find(Key key) const;

 private:
  std::span<const ObjectRow> rows_;
  const ObjectRange* ranges_ = nullptr;
};

namespace detail {

template <std::size_t n>
struct DistinctRanges {
  std::array<ObjectRange, n> ranges{};
  std::size_t size = 0;

  /// The index of a range in the table, to which it is added if it is new.
  constexpr std::size_t add(const ObjectRange& range) {
    const auto end = ranges.begin() + static_cast<std::ptrdiff_t>(size);
    const auto known = std::find(ranges.begin(), end, range);
    if (known == end) {
      ranges[size++] = range;
    }
    return static_cast<std::size_t>(known - ranges.begin());
  }
};

template <const auto& described>
inline constexpr auto distinct_ranges = [] {
  DistinctRanges<std::size(described)> all;
  for (const DescribedObject& row : described) {
    all.add({row.object.min, row.object.max});
  }
  return all;
}();

template <const auto& described>
inline constexpr auto range_table = [] {
  std::array<ObjectRange, distinct_ranges<described>.size> ranges{};
  std::copy_n(distinct_ranges<described>.ranges.begin(), ranges.size(), ranges.begin());
  return ranges;
}();

template <const auto& described>
inline constexpr auto row_table = [] {
  std::array<ObjectRow, std::size(described)> rows{};
  auto ranges = distinct_ranges<described>;
  static_assert(distinct_ranges<described>.size <= 128);
  std::ranges::transform(described, rows.begin(), [&](const DescribedObject& row) -> ObjectRow {
    const Object& o = row.object;
    return {o.key.index,
            o.key.sub,
            o.type,
            static_cast<std::uint16_t>(o.access & 0x1FFU),
            static_cast<std::uint16_t>(ranges.add({o.min, o.max}) & 0x7FU),
            o.at,
            o.standard};
  });
  return rows;
}();

}  // namespace detail

template <const auto& described>
inline constexpr ObjectRows without_texts{detail::row_table<described>,
                                          detail::range_table<described>.data()};

constexpr bool in_order(std::span<const DescribedObject> rows) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (!(rows[i - 1].object.key < rows[i].object.key)) {
      return false;
    }
  }
  return true;
}

/// The entry of sub-index 0, "highest sub-index", in any dictionary; its value is encoded in the
/// handle.
constexpr Entry highest_sub_entry(Key key, std::uint8_t highest) {
  return {key, Type::u8, readable | constant, static_cast<std::uint16_t>(0xFF00U | highest), 1};
}
constexpr bool is_highest_sub(const Entry& entry) {
  return entry.handle >> 8U == 0xFF;
}

/// Finds a key in `count` rows that are sorted by their keys, which key_of() gives. A sub-index 0
/// without a row of its own is the highest sub-index: `row` is then `count` and `entry` is
/// complete. In all other cases the caller has to fill `entry`.
Abort find_row(std::size_t count, Key (*key_of)(const void* rows, std::size_t row),
               const void* rows, Key key, Entry& entry, std::size_t& row);
Abort find_object(const ObjectRows& rows, Key key, Entry& entry);

/// Functions that read and write the value of an object that lives in `memory`.
std::uint32_t load(const Object& object, std::span<const std::byte> memory);
void keep(const Object& object, std::span<std::byte> memory, std::uint32_t value);
/// Sets every object to its default, plus the node-id for objects with `by_node`.
void reset_objects(const ObjectRows& rows, std::span<std::byte> memory, std::uint8_t node_id);
constexpr std::uint32_t default_of(const Object& object, std::uint8_t node_id) {
  return object.standard + ((object.access & by_node) != 0 ? node_id : 0U);
}

}  // namespace smaservo::canopen
