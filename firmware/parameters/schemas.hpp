#pragma once
// The parameters in the stored images of each release, and the ones moved since. An image is read
// by its keys, so any release can read any other's: it ignores unknown entries, and a parameter
// without an entry gets its default. Therefore a key never changes its meaning, type or unit; a
// parameter that must change gets a new key, and a row of `moved_parameters`.

#include "firmware/parameters/parameters.hpp"

namespace smaservo {

/// The sub-indices of one index, from 1 on, by their types: r(eal), n(umber), c(hoice), b(oolean);
/// a dash is unused.
struct SchemaObject {
  std::uint16_t index;
  std::string_view types;
};

inline constexpr auto schema_0_1_0 = std::to_array<SchemaObject>({
    {0x2000, "nn"},          {0x2001, "rrr"},         {0x2010, "rrrrrrrrbrr"},
    {0x2011, "rr"},          {0x2020, "rrrrrrrrrrr"}, {0x2021, "rrrrrrrrrrrrrrrrn"},
    {0x2022, "crr"},         {0x2030, "rr"},          {0x2100, "rrrrrrrrr"},
    {0x2101, "crrrr"},       {0x2103, "rrrrrrrrr"},   {0x2104, "rrrrrrrrr"},
    {0x2105, "rrrrrrrrr"},   {0x2106, "rrrrr"},       {0x2107, "rrr"},
    {0x2110, "rrrcrbbr"},    {0x2111, "rrrrrrrrrrr"}, {0x2112, "rrrrrrrrrrr"},
    {0x2113, "rrrrrrrrrrr"}, {0x2114, "rrrrrrrrrrr"}, {0x2115, "rrrrrrrrrrr"},
    {0x2116, "rrrrr"},       {0x2117, "rrrrr"},       {0x2118, "rrrrr"},
    {0x2119, "rc"},          {0x211A, "rrrrrrr"},     {0x211B, "rr"},
    {0x211C, "rrr"},
});

struct Schema {
  std::string_view version;  ///< first release with this schema
  std::span<const SchemaObject> objects;
};

/// The last schema is that of the present `parameters`.
inline constexpr auto released_schemas = std::to_array<Schema>({{"0.1.0", schema_0_1_0}});

/// A parameter that older releases stored under the key `from`: its value under `to` is factor
/// times the old one. Images are written with both entries, so that an older release finds its own.
/// Only reals may have factors other than 1.
struct Moved {
  Key from, to;
  float factor;
};

inline constexpr std::array<Moved, 0> moved_parameters{};

constexpr char letter(ValueType type) {
  return std::string_view("rncb")[static_cast<std::size_t>(type)];
}

/// FNV-1a over index, sub-index and type of every parameter, in the order of the keys.
class SchemaHash {
 public:
  constexpr void add(Key key, char type) {
    const auto byte_of = [](auto value) { return static_cast<std::uint8_t>(value); };
    for (const std::uint8_t byte :
         {byte_of(key.index), byte_of(key.index >> 8), key.sub, byte_of(type)}) {
      hash_ = (hash_ ^ byte) * 16777619U;
    }
  }
  constexpr std::uint32_t value() const { return hash_; }

 private:
  std::uint32_t hash_ = 2166136261U;
};

constexpr std::uint32_t schema_hash(std::span<const SchemaObject> objects) {
  SchemaHash hash;
  for (const SchemaObject& object : objects) {
    for (std::size_t i = 0; i < object.types.size(); ++i) {
      if (object.types[i] != '-') {
        hash.add({object.index, static_cast<std::uint8_t>(i + 1)}, object.types[i]);
      }
    }
  }
  return hash.value();
}

template <class S>
constexpr std::uint32_t schema_hash(std::span<const ParameterRow<S>> rows) {
  SchemaHash hash;
  for (const ParameterRow<S>& row : rows) {
    hash.add(row.key, letter(row.type));
  }
  return hash.value();
}

/// Version of the release that wrote an image with this hash; empty if no known release did.
constexpr std::string_view schema_version(std::uint32_t hash) {
  for (const Schema& schema : released_schemas) {
    if (schema_hash(schema.objects) == hash) {
      return schema.version;
    }
  }
  return "";
}

}  // namespace smaservo
