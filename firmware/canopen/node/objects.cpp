#include "firmware/canopen/node/objects.hpp"

#include <cstring>

namespace smaservo::canopen {
namespace {

Key key_of_object(const void* rows, std::size_t row) {
  return static_cast<const ObjectRows*>(rows)->key(row);
}

}  // namespace

Object ObjectRows::operator[](std::size_t i) const {
  const ObjectRow& row = rows_[i];
  const ObjectRange& range = ranges_[row.range];
  return {key(i), row.type, row.access, row.at, row.standard, range.min, range.max};
}

std::size_t ObjectRows::find(Key key) const {
  Entry entry{};
  std::size_t row = 0;
  return find_row(size(), key_of_object, this, key, entry, row) == Abort::none ? row : size();
}

Abort find_row(std::size_t count, Key (*key_of)(const void* rows, std::size_t row),
               const void* rows, Key key, Entry& entry, std::size_t& row) {
  std::size_t first = 0;
  for (std::size_t left = count; left > 0;) {
    const std::size_t half = left / 2;
    const bool below = key_of(rows, first + half) < key;
    first += below ? half + 1 : 0;
    left = below ? left - half - 1 : half;
  }
  if (first < count && key_of(rows, first) == key) {
    row = first;
    return Abort::none;
  }
  // Rows of the same index stand next to the place where the key would be.
  const auto same_index = [&](std::size_t i) {
    return i < count && key_of(rows, i).index == key.index;
  };
  if (!same_index(first) && (first == 0 || !same_index(first - 1))) {
    return Abort::no_object;
  }
  if (key.sub != 0) {
    return Abort::no_sub;
  }
  while (same_index(first + 1)) {
    ++first;
  }
  entry = highest_sub_entry(key, key_of(rows, first).sub);
  row = count;
  return Abort::none;
}

Abort find_object(const ObjectRows& rows, Key key, Entry& entry) {
  std::size_t row = 0;
  const Abort found = find_row(rows.size(), key_of_object, &rows, key, entry, row);
  if (found == Abort::none && row < rows.size()) {
    const Object object = rows[row];
    entry = {key, object.type, object.access, static_cast<std::uint16_t>(row),
             size_of(object.type)};
  }
  return found;
}

std::uint32_t load(const Object& object, std::span<const std::byte> memory) {
  std::array<std::uint8_t, 4> bytes{};
  const std::size_t size = size_of(object.type);
  std::memcpy(bytes.data(), memory.subspan(object.at, size).data(), size);
  return take_value(object.type, std::span(bytes).first(size));
}

void keep(const Object& object, std::span<std::byte> memory, std::uint32_t value) {
  std::array<std::uint8_t, 4> bytes{};
  put_number(bytes, value);
  const std::size_t size = size_of(object.type);
  std::memcpy(memory.subspan(object.at, size).data(), bytes.data(), size);
}

void reset_objects(const ObjectRows& rows, std::span<std::byte> memory, std::uint8_t node_id) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Object object = rows[i];
    if (object.at != nowhere) {
      keep(object, memory, default_of(object, node_id));
    }
  }
}

}  // namespace smaservo::canopen
