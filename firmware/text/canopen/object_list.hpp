#pragma once
// Lists all objects of the node with name and meaning: communication, drive, live values,
// parameters.

#include <string>
#include <vector>

#include "firmware/canopen/node/objects.hpp"
#include "firmware/parameters/parameter.hpp"

namespace smaservo::text {

struct ListedObject {
  canopen::Object object;
  std::string name, meaning;
  bool has_default = true;  ///< a wire's parameters have none
  bool is_parameter = false;
};

struct ListedIndex {
  std::uint16_t index;
  std::string name;
  /// The objects of the index. Sub-index 0 is left out if it only holds the number of sub-indices.
  std::vector<ListedObject> objects;

  /// Whether the index has only one object, at sub-index 0.
  bool is_variable() const { return objects.size() == 1 && objects[0].object.key.sub == 0; }
  std::uint8_t highest_sub() const { return objects.back().object.key.sub; }
};

/// The CANopen type of a parameter's value.
canopen::Type type_of(ValueType type);

/// The name of a type in CiA 301: "REAL32"
std::string_view type_text(canopen::Type type);

/// All indices in ascending order.
std::vector<ListedIndex> list_objects();

}  // namespace smaservo::text
