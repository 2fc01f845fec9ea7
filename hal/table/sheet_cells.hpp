#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace smaservo::hal {

/// A field of a line of CSV: in quotes where it needs them, line breaks and tabs as blanks.
std::string csv_field(std::string_view text);

/// Writes all of it; an error throws files::UserError.
void put(std::string_view text);

/// The cells of a sheet, in the order of its rows, and of the columns within.
class SheetCells {
 public:
  std::string name;
  bool hidden = false;

  /// An empty cell is left out. Rows and columns are counted from 0. What comes in another order or
  /// is larger than a sheet may be throws files::UserError.
  void add(std::size_t row, std::size_t column, std::string_view text, bool is_number);
  /// Rows with two numbers or more.
  std::size_t rows_of_numbers() const { return rows_of_numbers_; }
  /// Writes CSV: a line for each row of the sheet from the first, and for each column that a row of
  /// numbers reaches a field. Texts to the left and right of these are left out.
  void write() const;

 private:
  struct Cell {
    std::uint32_t row, column;
    std::size_t end;  ///< of its text in texts_
  };

  std::vector<Cell> cells_;
  std::string texts_;
  std::size_t rows_of_numbers_ = 0;
  std::size_t numbers_ = 0, row_ = 0, leftmost_ = 0;  ///< of the row that is being added
  std::size_t first_ = static_cast<std::size_t>(-1),
              width_ = 0;  ///< columns of the rows of numbers
};

/// What is written of a spreadsheet: the sheet with the most rows of numbers; of several the first;
/// a hidden one only where no other has any. Null: there are none.
const SheetCells* chosen_sheet(const std::vector<SheetCells>& sheets);

}  // namespace smaservo::hal
