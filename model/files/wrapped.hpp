#pragma once
// Texts in lines of a terminal.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace smaservo::files {

inline constexpr std::size_t terminal_columns = 80;

/// Columns that a text in UTF-8 takes: one for each of its code points.
std::size_t width_of(std::string_view text);

/// Breaks a text between words into lines of the given width; a longer word has a line of its own.
/// At least one line.
std::vector<std::string> broken(std::string_view text, std::size_t width);

/// The heading, filled up to `indent` columns, and the text beside it, in lines that end within 80
/// columns and begin at the indent. Ends with a line break.
std::string paragraph(std::string_view heading, std::string_view text, std::size_t indent);

/// The help of a command as CLI11 makes it, with descriptions from column 30 on, in lines of 80
/// columns.
std::string wrapped_help(std::string_view help);

}  // namespace smaservo::files
