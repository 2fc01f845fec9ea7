#pragma once

#include "hal/table/sheet_cells.hpp"
#include "hal/table/zip_archive.hpp"

namespace smaservo::hal {

struct Spreadsheet {
  std::string program;  ///< "Excel", "OpenDocument"
  std::vector<SheetCells> sheets;
};

/// The sheets of a file; another archive, or one of these that is encrypted or damaged, throws
/// files::UserError.
Spreadsheet read_spreadsheet(const ZipArchive& archive);

/// Of .xlsx: Office Open XML (ECMA-376). Without its cells' formats numbers would not be told from
/// dates.
std::vector<SheetCells> read_xlsx(const ZipArchive& archive);
/// Of .ods: OpenDocument (ISO 26300).
std::vector<SheetCells> read_ods(const ZipArchive& archive);

}  // namespace smaservo::hal
