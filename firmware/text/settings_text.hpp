#pragma once
// Parameters in the words of a file.

#include <string>
#include <string_view>

#include "firmware/parameters/parameters.hpp"
#include "model/files/fields.hpp"

namespace smaservo::text {

/// A path in its parts: "limits" and "current" of "limits.current_A".
struct KeyParts {
  std::string_view table, name;
};
KeyParts key_parts(const Parameter<double>& row);

/// A value as it is written: in SI, the name of a choice, true or false.
std::string value_text(const Parameter<double>& row, Value value);

/// "0.001 to 20", "off, hold, release", "true, false"
std::string range_text(const Parameter<double>& row);

/// "limits.current_A=0.12;safe.state=hold": what differs in `to`, in SI. Empty: nothing.
std::string changes_text(const Settings<double>& from, const Settings<double>& to);

/// Makes such changes, all or none. Empty, or what is wrong with the text; ranges are not checked.
std::string apply_changes(std::string_view text, Settings<double>& settings);

}  // namespace smaservo::text
