#pragma once
// TOML read strictly, by a table of fields: whatever is unknown, given twice, not finite or out of
// range is refused with file, line, key, value and what is allowed. All throw ConfigError.

#include <functional>
#include <optional>
#include <toml++/toml.h>

#include "model/files/toml/fields.hpp"

namespace smaservo::files {

/// `origin` names the text in error messages.
toml::table parse_toml(std::string_view text, const std::string& origin);

/// "KEY = VALUE" as given by --set, which is named as the origin; a value that is not TOML is a
/// string.
toml::table parse_override(const Override& setting);
inline constexpr std::string_view set_origin = "--set";

/// "FILE:LINE: KEY = VALUE"
std::string place(const std::string& origin, const std::string& key, const toml::node& node);

/// The node's value if it is a finite number.
std::optional<double> number_of(const toml::node& node);

/// The value of a string; anything else is refused with the message's "KEY = VALUE".
std::string string_of(const std::string& origin, const std::string& key, const toml::node& node);

/// A string as TOML writes it on one line, as a value or as a key.
std::string quoted(const std::string& text);

/// Handles a key or a table that is no field, given by its whole path; returns false if it is
/// unknown here, too.
using OtherKeys = std::function<bool(const std::string& key, const toml::node& node)>;

/// Reads the entries of a table. `fields` must outlive the result, which points into it.
Entries read_fields(std::span<const Field> fields, const toml::table& table,
                    const std::string& origin, const OtherKeys& other = {});

/// Replaces entries of `below` by those of `above`.
void overlay(Entries& below, const Entries& above);

}  // namespace smaservo::files
