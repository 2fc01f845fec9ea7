#pragma once
// The columns of a trace, as the schema of its messages says them.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace smaservo::hal::mcap {

enum class Kind : unsigned char { unknown, number, text };

struct TraceColumn {
  std::string name;
  Kind kind = Kind::unknown;
  bool operator==(const TraceColumn&) const = default;
};
using TraceColumns = std::vector<TraceColumn>;

/// The names of a header, without spaces around them.
std::vector<std::string> header_names(std::string_view header);
/// Splits a row; false if it does not have `count` fields.
bool split_row(std::string_view row, std::size_t count, std::vector<std::string_view>& fields);

/// The field as a JSON number: unchanged if it is one already, otherwise in the shortest form (".5"
/// becomes 0.5), which is written to `room`. Empty if the field is no number, not finite, or begins
/// with zeros: 007 is a name.
std::string_view as_number(std::string_view field, std::string& room);

/// Whether the field says that there is no value: nan, inf, NA, null, a dash, in any case.
bool says_no_value(std::string_view field);

/// The fields of a column so far.
struct FieldCounts {
  std::uint64_t numbers = 0, texts = 0;  ///< fields that are neither have no value
  std::uint64_t first_text_line = 0;
  std::string first_text;

  void add(std::string_view field, std::uint64_t line);
  /// A column is one of numbers where at least nine of ten values are numbers; unknown without any.
  Kind kind() const;
};

/// The JSON Schema of a row. A row leaves out members that have no value, because the schema's type
/// `number` has no null and Foxglove opens no channel whose schema has lists of types. Columns of
/// unknown kind are texts. Throws UserError if two columns have the same name or a name is not
/// UTF-8.
std::string schema_of(const TraceColumns& columns);
/// The columns that a JSON Schema of rows lists as members; none if it lists no members. Throws
/// UserError if it is not a JSON object.
TraceColumns columns_of(std::string_view schema);

}  // namespace smaservo::hal::mcap
