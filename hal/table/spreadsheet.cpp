#include "hal/table/spreadsheet.hpp"

#include "model/files/error.hpp"

namespace smaservo::hal {

Spreadsheet read_spreadsheet(const ZipArchive& archive) {
  const std::string type =
      archive.has("mimetype") ? archive.beginning("mimetype", 80) : std::string();
  if (type.starts_with("application/vnd.oasis.opendocument.spreadsheet")) {
    return {"OpenDocument", read_ods(archive)};
  }
  if (archive.has("xl/workbook.bin")) {
    throw files::UserError("is a binary Excel file (.xlsb); save it as .xlsx or CSV");
  }
  if (archive.has("_rels/.rels") && archive.has("[Content_Types].xml")) {
    return {"Excel", read_xlsx(archive)};
  }
  throw files::UserError("is a zip archive and no spreadsheet; unpack it first");
}

}  // namespace smaservo::hal
