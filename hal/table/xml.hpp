#pragma once

#include <string_view>

#include "hal/table/zip_archive.hpp"

namespace smaservo::hal {

/// The attributes of an element. Names are compared without their prefix: `r:id` is `id`.
class XmlAttributes {
 public:
  explicit XmlAttributes(const char** all) : all_(all) {}
  /// The value; empty where there is none.
  std::string_view operator[](std::string_view name) const;

 private:
  const char** all_;
};

/// What a reader of XML hears. Names are without their prefix: `table:table-row` is `table-row`.
struct XmlHandler {
  virtual void begin(std::string_view name, const XmlAttributes& attributes) = 0;
  virtual void end(std::string_view name) = 0;
  /// A text may come in several parts.
  virtual void text(std::string_view part) = 0;
  virtual ~XmlHandler() = default;
};

/// Reads a file of the archive. What is no XML throws files::UserError, and so does a declaration
/// of a document type: no spreadsheet has one, and entities might grow without end.
void read_xml(const ZipArchive& archive, const std::string& name, XmlHandler& handler);

}  // namespace smaservo::hal
