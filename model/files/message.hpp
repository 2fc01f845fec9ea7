#pragma once
// What programs say to people. Texts from outside (files and their names, the bus, the command
// line, the environment) may contain control characters; a terminal would obey these, and a line
// break would begin a line of the journal that nobody has written. So everything is printed by the
// functions of this file, which toolchain/dev check verifies.

#include <cstdio>
#include <string>
#include <string_view>

namespace smaservo::files {

/// Greatest length in bytes of the result of `printable`.
constexpr std::size_t longest_message = 4000;

/// A text from outside as a part of a line: control characters, bytes that are not UTF-8, and signs
/// that break lines or turn the direction of writing are replaced by escapes such as \x1B. A result
/// longer than `longest_message` loses its middle. Applying the function twice changes nothing
/// more.
std::string printable(std::string_view text);
/// Like printable(), for a text of several lines: line breaks and the full length are kept.
std::string printable_lines(std::string_view text);
/// Like printable(), for a JSON document of any number of lines; escapes are written as \u001b.
std::string printable_json(std::string_view document);
/// Like printable(), for the content of a quoted TOML string; escapes are written as \u001b, also
/// for line breaks.
std::string printable_toml(std::string_view text);

/// Opens those of the standard descriptors that a program was started without, so that no file and
/// no socket gets their numbers, and with these what is printed. Writing to them still fails.
void hold_standard_descriptors();
/// Writes "PROGRAM: TEXT" as one line on the standard error output. Does not throw.
void complain(std::string_view program, std::string_view text) noexcept;
/// Writes a text of several lines. The caller finds failures by std::ferror().
void print(std::string_view text, std::FILE* file = stdout);
/// Replaces the last line on the terminal of the standard error output; the new line stays when the
/// program ends.
void redraw(std::string_view line);
/// Empties the terminal of the standard output.
void clear_terminal();

}  // namespace smaservo::files
