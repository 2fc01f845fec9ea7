#pragma once
// A table that is made once and printed for the terminal, as Markdown, as HTML and as JSON.

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace smaservo::files {

class TextTable {
 public:
  /// A column with a format has numbers and is aligned to the right, one without has texts and is
  /// aligned to the left. A column without a key is left out of the JSON; one with a key and no
  /// heading stands only there.
  struct Column {
    // g++ warns of members that designated initializers leave out, unless they have their own
    // initializer.
    // NOLINTBEGIN(readability-redundant-member-init)
    std::string heading = {};
    std::string format = {};  ///< format of its real numbers, with the unit: "{:.1f} mA"
    std::string key = {};     ///< its name in JSON
    // NOLINTEND(readability-redundant-member-init)
    double scale = 1;  ///< factor on real numbers for people; JSON has them unscaled
  };

  /// A text, a number, a truth value or nothing; NaN counts as nothing. A marked cell has a star if
  /// its column is aligned to the right, is bold in Markdown and has the class "lost" in HTML.
  struct Cell {
    Cell() = default;
    template <class T>
      requires(!std::same_as<T, Cell>)
    Cell(const T& given, bool is_marked = false) : marked(is_marked) {
      if constexpr (std::same_as<T, bool> || std::floating_point<T>) {
        value = given;
      } else if constexpr (std::signed_integral<T>) {
        value = std::int64_t{given};
      } else if constexpr (std::unsigned_integral<T>) {
        value = std::uint64_t{given};
      } else {
        value = std::string(given);
      }
    }

    std::variant<std::nullptr_t, bool, std::int64_t, std::uint64_t, double, std::string> value;
    bool marked = false;
  };
  using Row = std::vector<Cell>;

  /// `nothing` is the text that people see in empty cells.
  explicit TextTable(std::vector<Column> columns, std::string nothing = "-")
      : columns_(std::move(columns)), nothing_(std::move(nothing)) {}

  /// Cells that a row does not give are empty.
  void add(Row row);
  bool empty() const { return rows_.empty(); }

  /// Columns are as wide as they must be; headings are broken if the table then has at most 80
  /// columns of characters.
  std::string text() const;
  std::string markdown() const;
  std::string html() const;
  /// A list with an object for each row.
  nlohmann::ordered_json json() const;

 private:
  std::vector<Column> columns_;
  std::vector<Row> rows_;
  std::string nothing_;
};

/// The text escaped for HTML, also inside an attribute; control characters are replaced as on a
/// terminal.
std::string escaped(std::string_view text);
/// The document as text: indented on several lines, or on one line with indent -1. Safe for a
/// terminal: bytes that are not UTF-8 are replaced, control characters are written as \u001b.
std::string json_text(const nlohmann::ordered_json& json, int indent = 2);

}  // namespace smaservo::files
