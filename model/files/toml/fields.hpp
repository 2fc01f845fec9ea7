#pragma once
// The keys of a file, described as a table. toml_fields.hpp reads them.

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/units.hpp"

namespace smaservo::files {

/// "wire.length_m", "0.12": replaces a key of a file, in any unit of its kind.
using Override = std::pair<std::string, std::string>;

enum class FieldType : unsigned char {
  number,
  list,        ///< a list of `count` numbers
  polynomial,  ///< 1 to `count` coefficients by power of the stress
  whole,       ///< a number without fraction
  choice,      ///< one of several names; stored as the index of the name
  flag,        ///< false or true, as 0 or 1
};

/// One key without its unit, and the slots that its numbers fill.
struct Field {
  std::string path;  ///< "wire.length": table and name
  FieldType type;
  Kind kind;              ///< unit kind of a number, or of a polynomial's value
  double min, max;        ///< SI, inclusive; for a polynomial, of its value at 0 Pa
  std::size_t slot;       ///< slot of the first number
  std::size_t count = 1;  ///< number of slots that it fills
  std::span<const std::string_view> choices;  ///< names of a choice
  std::string meaning;
};

/// What a file says about one slot.
struct Entry {
  double number;       ///< SI
  const Field* field;  ///< the key that gave the number
  std::string where;   ///< "FILE:LINE: KEY = VALUE", for error messages
};
using Entries = std::map<std::size_t, Entry>;

/// A unit as a key ends in it: "mm", or "degC_by_MPa" for a polynomial, whose value is in °C and
/// whose coefficients are per MPa, per MPa², ...
struct KeyUnit {
  std::string suffix;
  Unit value;
  double stress_Pa = 1;  ///< for a polynomial: the stress unit in Pa
};
/// All units that a key of this field may end in; the SI unit is the first.
std::vector<KeyUnit> key_units(const Field& field);

/// The present name of an old key of any file or of --set; empty if it is not an old key. To be
/// called only for unknown keys, because "limits." is also a table of a device's settings.
std::string renamed_key(std::string_view key);

/// "current" and "mA", "duty" and ""
std::string key_with(std::string_view name, std::string_view suffix);

}  // namespace smaservo::files
