#pragma once
// What programs say to people. Texts from outside (files and their names, the bus, the command
// line, the environment) may contain control characters; a terminal would obey these, and a line
// break would begin a line of the journal that nobody has written. So everything is printed by the
// functions of this file, which toolchain/dev check verifies.

#include <cstdio>
#include <string>
#include <string_view>

namespace smaservo::files {

/// Greatest number of bytes of what `printable` makes.
constexpr std::size_t longest_message = 4000;

/// A text from outside as a part of a line: control characters, bytes that are no UTF-8, and signs
/// that break lines or turn the direction of writing stand as \x1B. Of what becomes longer than
/// `longest_message`, the middle is left out. Applied twice it changes nothing more.
std::string printable(std::string_view text);
/// The same for a text of several lines: line breaks stay, and the length.
std::string printable_lines(std::string_view text);
/// The same for a JSON document of any number of lines: \u001b.
std::string printable_json(std::string_view document);
/// The same for what stands between the quotes of a TOML string: \u001b, also for line breaks.
std::string printable_toml(std::string_view text);

/// Writes "PROGRAM: TEXT" as one line on the standard error output. Does not throw.
void complain(std::string_view program, std::string_view text) noexcept;
/// Writes a text of several lines. What fails then is left to std::ferror().
void print(std::string_view text, std::FILE* file = stdout);
/// Writes a line on the terminal of the standard error output in the place of the one before;
/// nothing takes that away.
void redraw(std::string_view line);
/// Empties the terminal of the standard output.
void clear_terminal();

}  // namespace smaservo::files
