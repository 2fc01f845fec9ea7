#pragma once
// How the text of a table is laid out: what separates the fields, which sign stands before the
// decimals, in which line the names are, in which the units, where the rows begin.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace smaservo::hal {

struct SheetLayout {
  char separator = ',';  ///< a blank: any number of blanks and tabs
  char decimal = '.';
  std::size_t columns = 0;
  std::size_t header = 0;          ///< number of the line of names, from 1; 0: there is none
  std::size_t units = 0;           ///< number of the line of units; 0: there is none
  std::size_t first = 0;           ///< number of the first row's line
  bool begins_with_number = true;  ///< a row
  std::vector<std::string> names;  ///< with their units, as "I [mA]"; "1", "2" without a header
};

/// Whether the fields of a line may be those of a row: as many as the header has, a third of
/// them numbers, and a number first where the other rows begin with one.
bool is_sheet_row(const std::vector<std::string>& fields, const SheetLayout& layout);

/// Splits a line into its fields, without blanks around them; quotes keep a separator and are
/// taken off.
void split_sheet_line(std::string_view line, char separator, std::vector<std::string>& fields);

/// The number as plain text with a point; nullopt if the field is none. Times as `12:30:05,25`,
/// `4:30:05 PM` and `2026-11-28 12:30:05.25+01:00` are numbers of seconds, since midnight and since
/// 1970.
std::optional<std::string> plain_number(std::string_view field, char decimal);

/// The layout of a table, by its beginning; nullopt if there is no table of numbers.
std::optional<SheetLayout> find_layout(const std::vector<std::string_view>& lines);

}  // namespace smaservo::hal
