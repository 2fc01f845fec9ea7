#pragma once
// Finds objects of a servo node by name: parameters, live values, objects of drive and
// communication.

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
  std::string name;     ///< a parameter's path, "live.wire_temperature_K", "6041h:0 Statusword" ...
  std::string meaning;  ///< may be empty
  bool writable;
  const Parameter<double>* parameter;  ///< nullptr: the object is no parameter
  Unit unit{"", 1};                    ///< of the object's texts
};

/// All objects in the order of their keys.
const std::vector<KnownObject>& known_objects();

/// Finds an object by its name, a parameter in any unit of its kind ("limits.current_mA"), or by
/// its key: "2100:1", "2100h:1", "0x2100:1"; sub-index 0 may be left out. An unknown key gives an
/// object of type octets. Throws UserError, which lists similar names.
KnownObject find_object(const std::string& text);

/// Name and key of an object: "limits.current_A (2020h:2)"
std::string title(const KnownObject& object);

/// Text of a value: a number in the object's unit, the name of a choice, octets in hexadecimal
/// digits.
std::string value_text(const KnownObject& object, std::span<const std::uint8_t> bytes);
/// The value as a number, in SI for a parameter; NaN where the object's type is no number.
double value_number(const KnownObject& object, std::span<const std::uint8_t> bytes);
/// The bytes of a value given as text. Throws UserError, which says what is allowed; ranges are
/// checked by the node.
std::vector<std::uint8_t> value_bytes(const KnownObject& object, const std::string& text);
/// The range or choices of a parameter, with its unit; "" where nothing is known.
std::string allowed_text(const KnownObject& object);

}  // namespace smaservo::text
