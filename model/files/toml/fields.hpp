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
  list,        ///< of `count` numbers
  polynomial,  ///< 1 to `count` coefficients by power of the stress
  whole,       ///< a number without fraction
  choice,      ///< one of some names; its number is the index of the name
  flag,        ///< false or true, as 0 or 1
};

/// One key, without its unit, and where its numbers go.
struct Field {
  std::string path;  ///< "wire.length": table and name
  FieldType type;
  Kind kind;                                  ///< of a number; of a polynomial's value
  double min, max;                            ///< SI, inclusive; of a polynomial's value at 0 Pa
  std::size_t slot;                           ///< of the first number
  std::size_t count = 1;                      ///< slots that it fills
  std::span<const std::string_view> choices;  ///< of a choice
  std::string meaning;
};

/// What a file says about one slot.
struct Entry {
  double number;       ///< SI
  const Field* field;  ///< the key that has said it
  std::string where;   ///< "FILE:LINE: KEY = VALUE", for error messages
};
using Entries = std::map<std::size_t, Entry>;

/// A unit in a key: "mm", or "degC_by_MPa" of a polynomial, which is a value in °C with
/// coefficients per MPa, per MPa², ...
struct KeyUnit {
  std::string suffix;
  Unit value;
  double stress_Pa = 1;  ///< of a polynomial
};
/// All that a key may end in; the first one is SI's.
std::vector<KeyUnit> key_units(const Field& field);

/// What an old key is called now, of any file or --set; empty: it is not an old one. To be asked
/// for keys that are unknown: "limits." is also a table of a device's settings.
std::string renamed_key(std::string_view key);

/// "current" and "mA", "duty" and ""
std::string key_with(std::string_view name, std::string_view suffix);

}  // namespace smaservo::files
