#pragma once
// TOML read strictly, by a table of fields: whatever is unknown, given twice, not finite or out of
// range is refused with file, line, key, value and what is allowed. All throw ConfigError.

#include <functional>
#include <optional>
#include <toml++/toml.h>

#include "model/files/toml/fields.hpp"

namespace smaservo::files {

/// `origin` is what messages call the text.
toml::table parse_toml(std::string_view text, const std::string& origin);

/// "KEY = VALUE" as of --set, which is its origin: a value that is no TOML is a string.
toml::table parse_override(const Override& setting);
inline constexpr std::string_view set_origin = "--set";

/// "FILE:LINE: KEY = VALUE"
std::string place(const std::string& origin, const std::string& key, const toml::node& node);

/// The finite number that a node is.
std::optional<double> number_of(const toml::node& node);

/// "name = 3", refused where it is no string.
std::string string_of(const std::string& origin, const std::string& key, const toml::node& node);

/// A string as it stands in a file, as a value or as a key: on one line.
std::string quoted(const std::string& text);

/// Takes a key or a table that is no field, by its whole path; false: it is unknown here, too.
using OtherKeys = std::function<bool(const std::string& key, const toml::node& node)>;

/// The entries of a table, whose keys stand below `fields`, which must outlive them.
Entries read_fields(std::span<const Field> fields, const toml::table& table,
                    const std::string& origin, const OtherKeys& other = {});

/// Puts `above` on top of `below`.
void overlay(Entries& below, const Entries& above);

}  // namespace smaservo::files
