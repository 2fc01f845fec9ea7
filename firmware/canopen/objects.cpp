#include "firmware/canopen/objects.hpp"

#include <cstring>

namespace smaservo::canopen {

Abort find_object(std::span<const Object> rows, Key key, Entry& entry) {
  return find_row<Object>(
      rows, key, entry, [](const Object& row) { return row.type; },
      [](const Object& row) { return row.access; });
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
