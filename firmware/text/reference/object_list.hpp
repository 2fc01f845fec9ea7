#pragma once
// Every object of the node, with its texts: communication, drive, live values, parameters.

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
  std::vector<ListedObject> objects;  ///< without sub-index 0, where it only counts

  /// The object is the index: nothing but sub-index 0.
  bool is_variable() const { return objects.size() == 1 && objects[0].object.key.sub == 0; }
  std::uint8_t highest_sub() const { return objects.back().object.key.sub; }
};

/// Of a parameter, as CANopen has it.
canopen::Type type_of(ValueType type);

/// "REAL32"
std::string_view type_text(canopen::Type type);

/// In the order of their indices.
std::vector<ListedIndex> list_objects();

}  // namespace smaservo::text
