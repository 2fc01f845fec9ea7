#pragma once
// The objects of a servo node by name: parameters, live values, the drive, the communication.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "firmware/canopen/node/object.hpp"
#include "firmware/parameters/parameters.hpp"

namespace smaservo::text {

struct KnownObject {
  Key key;
  canopen::Type type;
  std::string name;     ///< a parameter's path, "live.temperature_K", "6041h:0 Statusword" ...
  std::string meaning;  ///< may be empty
  bool writable;
  const Parameter<double>* parameter;  ///< nullptr: it is none
  Unit unit{"", 1};                    ///< in which texts are
};

/// All of them in the order of their keys.
const std::vector<KnownObject>& known_objects();

/// By name, a parameter in any unit of its kind ("limits.current_mA"), or by key: "2100:1",
/// "2100h:1", "0x2100:1"; sub-index 0 may be left out. A key that is not known has the type
/// octets: its bytes. Throws UserError, with names that are close.
KnownObject find_object(const std::string& text);

/// What it is called, with its key: "limits.current_A (2020h:2)"
std::string title(const KnownObject& object);

/// In the object's unit; a choice's name, an octet string in hexadecimal digits.
std::string value_text(const KnownObject& object, std::span<const std::uint8_t> bytes);
/// A number as it is, in SI; of any type that is one, else NaN.
double value_number(const KnownObject& object, std::span<const std::uint8_t> bytes);
/// Throws UserError with what is allowed. Ranges are the node's business.
std::vector<std::uint8_t> value_bytes(const KnownObject& object, const std::string& text);
/// What a parameter may be, with its unit; "" where nothing is known.
std::string allowed_text(const KnownObject& object);

}  // namespace smaservo::text
