#pragma once
// Parameters as text, as files write them.

#include <optional>
#include <string>
#include <string_view>

#include "firmware/parameters/parameters.hpp"
#include "model/files/toml/fields.hpp"

namespace smaservo::text {

/// The parts of a path: "limits" and "current" of "limits.current_A".
struct KeyParts {
  std::string_view table, name;
};
KeyParts key_parts(const Parameter<double>& row);

/// A number with or without a unit behind it: "120degC", "120 °C", "0.8mm", "4%", "3 mm/s", "2
/// 1/s".
struct Quantity {
  double number;
  std::string_view unit;  ///< as the text has it; empty: none

  /// The unit among those of a kind; nullopt if it is none of them. `plain` is that of a number
  /// without a unit.
  std::optional<Unit> unit_in(Kind kind, const Unit& plain) const;
};
/// nullopt if the text does not begin with a number.
std::optional<Quantity> quantity_of(std::string_view text);

/// The suffixes of a kind's units: "K, degC"
std::string suffixes_text(Kind kind);

/// Text of a value: a number in SI, the name of a choice, true or false.
std::string value_text(const Parameter<double>& row, Value value);

/// What a parameter may be: "0.001 to 20", "off, hold, release", "true, false"
std::string range_text(const Parameter<double>& row);

/// The parameters that differ, with their values in `to` in SI:
/// "limits.current_A=0.12;safe.state=hold". Empty: none differ.
std::string changes_text(const Settings<double>& from, const Settings<double>& to);

/// Applies such changes, all or none; ranges are not checked. Returns what is wrong with the text;
/// empty: nothing.
std::string apply_changes(std::string_view text, Settings<double>& settings);

}  // namespace smaservo::text
