#pragma once
// Electronic data sheets of CANopen devices (CiA 306), as far as a node needs them.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/canopen/node/object.hpp"

namespace smaservo {

struct EdsObject {
  Key key;
  std::string name;
  canopen::Type type;
  std::uint16_t access;  ///< bits of canopen/object.hpp
  std::vector<std::uint8_t>
      standard;             ///< default value as it is sent; zero, or nothing, where there is none
  bool has_limits = false;  ///< limits are given; only for whole numbers of up to 32 bits
  std::int64_t min = 0, max = 0;
};

struct Eds {
  std::string vendor, product;
  std::uint32_t vendor_number = 0, product_number = 0, revision = 0;
  std::vector<EdsObject> objects;  ///< sorted by key, each key once
};

/// $NODEID in numbers is node_id. Throws UserError with file, line or section, key and value.
Eds parse_eds(std::string_view text, const std::string& file, std::uint8_t node_id);

}  // namespace smaservo
