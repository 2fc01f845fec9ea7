#pragma once
// Every object of the node, with its texts: communication, drive, live values, parameters.

#include <string>
#include <vector>

#include "firmware/canopen/node/objects.hpp"

namespace smaservo {

struct ListedObject {
  canopen::Object object;
  std::string name, meaning;
  bool has_default = true;  ///< a wire's parameters have none
};

struct ListedIndex {
  std::uint16_t index;
  std::string name;
  std::vector<ListedObject> objects;  ///< without sub-index 0, where it only counts

  /// The object is the index: nothing but sub-index 0.
  bool is_variable() const { return objects.size() == 1 && objects[0].object.key.sub == 0; }
  std::uint8_t highest_sub() const { return objects.back().object.key.sub; }
};

/// In the order of their indices.
std::vector<ListedIndex> list_objects();

}  // namespace smaservo
