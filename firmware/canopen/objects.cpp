#include "firmware/canopen/objects.hpp"

#include <cstring>

namespace smaservo::canopen {

Abort find_object(std::span<const Object> rows, Key key, Entry& entry) {
  const auto at = std::ranges::lower_bound(rows, key, {}, &Object::key);
  if (at != rows.end() && at->key == key) {
    const auto handle = static_cast<std::uint16_t>(at - rows.begin());
    entry = {key, at->type, at->access, handle, size_of(at->type)};
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

void reset_objects(std::span<const Object> rows, std::span<std::byte> memory,
                   std::uint8_t node_id) {
  for (const Object& object : rows) {
    if (object.at != nowhere) {
      keep(object, memory, default_of(object, node_id));
    }
  }
}

}  // namespace smaservo::canopen
