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
  /// A column with a format has numbers and stands right, one without has texts and stands left.
  /// A column without a key is not in the JSON; one with a key and no heading is there only.
  struct Column {
    // g++ warns of what designated initializers leave out, unless it has one of its own.
    // NOLINTBEGIN(readability-redundant-member-init)
    std::string heading = {};
    std::string format = {};  ///< of its real numbers, with a unit: "{:.1f} mA"
    std::string key = {};     ///< its name in JSON
    // NOLINTEND(readability-redundant-member-init)
    double scale = 1;  ///< of real numbers for people; in JSON they stand as given
  };

  /// A text, a number, a truth value or nothing; NaN is nothing. What is marked has a star where it
  /// stands right, is bold in Markdown and of the class "lost" in HTML.
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

  /// `nothing` stands for people where there is nothing.
  explicit TextTable(std::vector<Column> columns, std::string nothing = "-")
      : columns_(std::move(columns)), nothing_(std::move(nothing)) {}

  /// There is nothing in cells that are not given.
  void add(Row row);
  bool empty() const { return rows_.empty(); }

  /// Columns as wide as they must be; headings are broken where the table then has 80 columns or
  /// less.
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

/// Text as HTML shows it, also inside an attribute; control characters as on a terminal.
std::string escaped(std::string_view text);
/// A document in lines, or without an indent (-1) in one. A terminal may show it: bytes that are no
/// UTF-8 are replaced, control characters are \u001b.
std::string json_text(const nlohmann::ordered_json& json, int indent = 2);

}  // namespace smaservo::files
