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
  /// the units that it has, SI's own first; empty: none
  Kind kind = {};  // NOLINT(readability-redundant-member-init)
};

/// The object with its texts in this unit of its kind, and with its name, which ends in the unit.
KnownObject in_unit(const KnownObject& object, const Unit& unit);

/// All objects in the order of their keys.
const std::vector<KnownObject>& known_objects();

/// Finds an object by its name, parameters and live values in any unit of their kind
/// ("limits.current_mA", "live.position_um"), live values also without "live."; or by its key:
/// "2100:1", "2100h:1", "0x2100:1"; sub-index 0 may be left out. An unknown key gives an object of
/// type octets. Throws UserError, which lists similar names.
KnownObject find_object(const std::string& text);

/// Like find_object(); a name without a unit, such as "limits.current" or "position", also finds a
/// parameter or live value, in SI, and sets `unitless`.
KnownObject find_quantity(const std::string& text, bool& unitless);

/// Name and key of an object: "limits.current_A (2020h:2)"
std::string title(const KnownObject& object);

/// Text of a value: a number in the object's unit, the name of a choice, octets in hexadecimal
/// digits.
std::string value_text(const KnownObject& object, std::span<const std::uint8_t> bytes);
/// The value as a number, in SI for a parameter or live value; NaN where the object's type is no
/// number.
double value_number(const KnownObject& object, std::span<const std::uint8_t> bytes);
/// The bytes of a value given as text: a number in the object's unit, or one with another unit of
/// its kind behind it ("120degC"). Throws UserError, which says what is allowed; ranges are
/// checked by the node.
std::vector<std::uint8_t> value_bytes(const KnownObject& object, const std::string& text);
/// The range or choices of a parameter, with its unit; "" where nothing is known.
std::string allowed_text(const KnownObject& object);

}  // namespace smaservo::text
