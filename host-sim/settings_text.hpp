#pragma once
// Parameters in the words of a file.

#include <string>
#include <string_view>

#include "firmware/parameters.hpp"

namespace smaservo {

/// A path in its parts: "limits" and "current" of "limits.current_A".
struct KeyParts {
  std::string_view table, name;
};
KeyParts key_parts(const Parameter<double>& row);

/// "current_mA", "duty"
std::string key_with(std::string_view name, const Unit& unit);

/// A value as it is written: in SI, the name of a choice, true or false.
std::string value_text(const Parameter<double>& row, Value value);

/// "0.001 to 20", "off, hold, release", "true, false"
std::string range_text(const Parameter<double>& row);

}  // namespace smaservo
