#include "hal/table/sheet_cells.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "model/files/error.hpp"

namespace smaservo::hal {
namespace {

/// Of Excel's sheets.
constexpr std::size_t most_rows = std::size_t{1} << 20, most_columns = std::size_t{1} << 14;
/// A file of a few bytes can say that a cell is repeated this often.
constexpr std::size_t most_cells = 30'000'000;

}  // namespace

std::string csv_field(std::string_view text) {
  std::string field(text);
  std::ranges::replace_if(
      field, [](char c) { return c == '\n' || c == '\r' || c == '\t' || c == '\0'; }, ' ');
  if (field.find_first_of(",;\" #%") == std::string::npos) {
    return field;
  }
  std::string quoted = "\"";
  for (const char c : field) {
    quoted.append(c == '"' ? 2 : 1, c);
  }
  return quoted + '"';
}

void put(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) {
    throw files::UserError(std::strerror(errno));
  }
}

void SheetCells::add(std::size_t row, std::size_t column, std::string_view text, bool is_number) {
  if (text.empty()) {
    return;
  }
  if (row >= most_rows || column >= most_columns || cells_.size() >= most_cells) {
    throw files::UserError(
        "a sheet has more than 1048576 rows, 16384 columns or 30 million cells; save it as CSV");
  }
  if (!cells_.empty() &&
      (row < cells_.back().row || (row == cells_.back().row && column <= cells_.back().column))) {
    throw files::UserError("the file is damaged: cells of a sheet are not in their order");
  }
  if (cells_.empty() || row != row_) {
    row_ = row;
    numbers_ = 0;
    leftmost_ = column;
  }
  texts_ += text;
  cells_.push_back(
      {static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(column), texts_.size()});
  numbers_ += is_number ? 1 : 0;
  if (is_number && numbers_ == 2) {
    ++rows_of_numbers_;
  }
  if (numbers_ >= 2) {
    first_ = std::min(first_, leftmost_);
    width_ = std::max(width_, column + 1);
  }
}

void SheetCells::write() const {
  std::string line;
  std::size_t row = 0;
  std::size_t column = first_;
  std::size_t begin = 0;
  std::size_t filled = 0;
  const auto end_line = [&] {
    // Rows of a table have the same number of fields; a title in one cell is none.
    line.append(filled > 1 ? width_ - 1 - column : 0, ',');
    line += '\n';
    put(line);
    line.clear();
    column = first_;
    filled = 0;
    ++row;
  };
  for (const Cell& cell : cells_) {
    while (row < cell.row) {
      end_line();
    }
    if (first_ <= cell.column && cell.column < width_) {
      line.append(cell.column - column, ',');
      line += csv_field(std::string_view(texts_).substr(begin, cell.end - begin));
      column = cell.column;
      ++filled;
    }
    begin = cell.end;
  }
  end_line();
}

const SheetCells* chosen_sheet(const std::vector<SheetCells>& sheets) {
  const SheetCells* best = nullptr;
  const auto better = [&](const SheetCells& sheet) {
    return sheet.rows_of_numbers() > 0 &&
           (best == nullptr || (best->hidden && !sheet.hidden) ||
            (best->hidden == sheet.hidden && sheet.rows_of_numbers() > best->rows_of_numbers()));
  };
  for (const SheetCells& sheet : sheets) {
    if (better(sheet)) {
      best = &sheet;
    }
  }
  return best;
}

}  // namespace smaservo::hal
