#include <charconv>
#include <fmt/format.h>
#include <map>

#include "hal/table/cell_text.hpp"
#include "hal/table/spreadsheet.hpp"
#include "hal/table/xml.hpp"
#include "model/files/error.hpp"

namespace smaservo::hal {
namespace {

/// The whole number that a text begins with; `none` where there is none.
std::size_t whole_number(std::string_view text, std::size_t none) {
  std::size_t value = none;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

struct Relation {
  std::string type, target;
};

/// Which file of the archive is which part of a document, by the part's identifier.
class Relations final : public XmlHandler {
 public:
  std::map<std::string, Relation, std::less<>> all;

  void begin(std::string_view name, const XmlAttributes& attributes) override {
    if (name == "Relationship") {
      const std::string_view type = attributes["Type"];
      all[std::string(attributes["Id"])] = {std::string(type.substr(type.rfind('/') + 1)),
                                            std::string(attributes["Target"])};
    }
  }
  void end(std::string_view /*name*/) override {}
  void text(std::string_view /*part*/) override {}

  /// The target of the first one of this type, or "".
  std::string of_type(std::string_view type) const {
    for (const auto& [id, relation] : all) {
      if (relation.type == type) {
        return relation.target;
      }
    }
    return "";
  }
};

class Workbook final : public XmlHandler {
 public:
  struct Listed {
    std::string name, id;
    bool hidden;
  };
  std::vector<Listed> sheets;
  bool since_1904 = false;

  void begin(std::string_view name, const XmlAttributes& attributes) override {
    if (name == "sheet") {
      const std::string_view state = attributes["state"];
      sheets.push_back({std::string(attributes["name"]), std::string(attributes["id"]),
                        state == "hidden" || state == "veryHidden"});
    } else if (name == "workbookPr") {
      since_1904 = attributes["date1904"] == "1" || attributes["date1904"] == "true";
    }
  }
  void end(std::string_view /*name*/) override {}
  void text(std::string_view /*part*/) override {}
};

/// Texts that cells share. Of a text in several fonts the parts are joined; how it is pronounced is
/// left out.
class SharedStrings final : public XmlHandler {
 public:
  std::vector<std::string> all;

  void begin(std::string_view name, const XmlAttributes& /*attributes*/) override {
    if (name == "si") {
      all.emplace_back();
    }
    in_text_ = name == "t" && !spoken_ && !all.empty();
    spoken_ = spoken_ || name == "rPh";
  }
  void end(std::string_view name) override {
    in_text_ = false;
    spoken_ = spoken_ && name != "rPh";
  }
  void text(std::string_view part) override {
    if (in_text_) {
      all.back() += part;
    }
  }

 private:
  bool in_text_ = false, spoken_ = false;
};

/// What the styles of cells make of numbers.
class Styles final : public XmlHandler {
 public:
  std::vector<CellFormat> cells;

  void begin(std::string_view name, const XmlAttributes& attributes) override {
    if (name == "numFmt") {
      own_[whole_number(attributes["numFmtId"], 0)] = format_of(attributes["formatCode"]);
    } else if (name == "cellXfs") {
      inside_ = true;
    } else if (inside_ && name == "xf") {
      const std::size_t id = whole_number(attributes["numFmtId"], 0);
      const auto own = own_.find(id);
      cells.push_back(own != own_.end()
                          ? own->second
                          : built_in_format(static_cast<int>(std::min<std::size_t>(id, 1000))));
    }
  }
  void end(std::string_view name) override { inside_ = inside_ && name != "cellXfs"; }
  void text(std::string_view /*part*/) override {}

 private:
  std::map<std::size_t, CellFormat> own_;
  bool inside_ = false;
};

/// What the cells of all sheets refer to.
struct Common {
  SharedStrings strings;
  Styles styles;
  bool since_1904 = false;
};

class Worksheet final : public XmlHandler {
 public:
  Worksheet(const Common& common, SheetCells& cells) : common_(common), cells_(cells) {}

  void begin(std::string_view name, const XmlAttributes& attributes) override {
    if (name == "row") {
      row_ = whole_number(attributes["r"], row_ + 1);
      column_ = 0;
    } else if (name == "c") {
      place(attributes["r"]);
      type_ = attributes["t"];
      style_ = whole_number(attributes["s"], 0);
      value_.clear();
    }
    in_value_ = name == "v" || (name == "t" && type_ == "inlineStr" && !spoken_);
    spoken_ = spoken_ || name == "rPh";
  }
  void end(std::string_view name) override {
    in_value_ = false;
    spoken_ = spoken_ && name != "rPh";
    if (name == "c") {
      add();
    }
  }
  void text(std::string_view part) override {
    if (in_value_) {
      value_ += part;
    }
  }

 private:
  /// A cell's name as "AB12"; without one it follows the cell before.
  void place(std::string_view name) {
    ++column_;
    std::size_t column = 0;
    while (!name.empty() && 'A' <= name.front() && name.front() <= 'Z' && column < 100'000) {
      column = 26 * column + static_cast<std::size_t>(name.front() - 'A') + 1;
      name.remove_prefix(1);
    }
    if (column > 0) {
      column_ = column;
      row_ = whole_number(name, row_);
    }
  }

  void add() {
    if (row_ == 0) {
      throw files::UserError("the file is damaged: a sheet has a cell outside of its rows");
    }
    const auto put = [&](std::string_view text, bool number) {
      cells_.add(row_ - 1, column_ - 1, text, number);
    };
    if (type_ == "s") {
      const std::size_t index = whole_number(value_, common_.strings.all.size());
      if (index >= common_.strings.all.size() && !value_.empty()) {
        throw files::UserError("the file is damaged: a cell has a text that is not there");
      }
      put(value_.empty() ? "" : common_.strings.all[index], false);
    } else if (type_.empty() || type_ == "n") {
      put_number(put);
    } else {
      // A truth value, a date as text; else the text of a formula or an error.
      put(value_, type_ == "b" || type_ == "d");
    }
  }

  template <class Put>
  void put_number(const Put& put) {
    double value = 0;
    const char* const stop = value_.data() + value_.size();
    const auto [at, error] = std::from_chars(value_.data(), stop, value);
    if (error != std::errc{} || at != stop) {
      put(value_, false);
      return;
    }
    const auto& formats = common_.styles.cells;
    const CellFormat format = style_ < formats.size() ? formats[style_] : CellFormat::number;
    put(cell_text(value, format, common_.since_1904), true);
  }

  const Common& common_;
  SheetCells& cells_;
  std::size_t row_ = 0, column_ = 0, style_ = 0;  ///< rows and columns from 1; 0: none yet
  std::string type_, value_;
  bool in_value_ = false, spoken_ = false;
};

/// A target as a name in the archive: relative to the folder, or from the top.
std::string in_folder(const std::string& folder, const std::string& target) {
  return target.starts_with('/') ? target.substr(1) : folder + target;
}

}  // namespace

std::vector<SheetCells> read_xlsx(const ZipArchive& archive) {
  Relations top;
  read_xml(archive, "_rels/.rels", top);
  const std::string target = top.of_type("officeDocument");
  if (target.empty()) {
    throw files::UserError("is a zip archive and no spreadsheet; unpack it first");
  }
  const std::string book = in_folder("", target);
  const std::size_t slash = book.rfind('/') + 1;
  const std::string folder = book.substr(0, slash);
  Workbook workbook;
  read_xml(archive, book, workbook);
  Relations parts;
  read_xml(archive, fmt::format("{}_rels/{}.rels", folder, book.substr(slash)), parts);
  Common common;
  common.since_1904 = workbook.since_1904;
  if (const std::string part = parts.of_type("sharedStrings"); !part.empty()) {
    read_xml(archive, in_folder(folder, part), common.strings);
  }
  if (const std::string part = parts.of_type("styles"); !part.empty()) {
    read_xml(archive, in_folder(folder, part), common.styles);
  }
  std::vector<SheetCells> sheets;
  for (const Workbook::Listed& listed : workbook.sheets) {
    const auto found = parts.all.find(listed.id);
    // A sheet that is a chart has no cells.
    if (found != parts.all.end() && found->second.type == "worksheet") {
      SheetCells& cells = sheets.emplace_back();
      cells.name = listed.name;
      cells.hidden = listed.hidden;
      Worksheet worksheet(common, cells);
      read_xml(archive, in_folder(folder, found->second.target), worksheet);
    }
  }
  if (workbook.sheets.empty()) {
    throw files::UserError("is an Office file without sheets; a spreadsheet is wanted");
  }
  return sheets;
}

}  // namespace smaservo::hal
