#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "hal/table/cell_text.hpp"
#include "hal/table/spreadsheet.hpp"
#include "hal/table/xml.hpp"
#include "model/files/error.hpp"

namespace smaservo::hal {
namespace {

/// How often a row or a cell is repeated.
std::size_t times(std::string_view text) {
  std::size_t count = 1;
  std::from_chars(text.data(), text.data() + text.size(), count);
  return std::max<std::size_t>(count, 1);
}

/// A duration as `PT12H30M05.25S`, in days; NaN if it is none.
double days_of_duration(std::string_view text) {
  if (!text.starts_with("PT")) {
    return std::nan("");
  }
  text.remove_prefix(2);
  double seconds = 0;
  while (!text.empty()) {
    double value = 0;
    const auto [at, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const auto used = static_cast<std::size_t>(at - text.data());
    if (error != std::errc{} || used == text.size()) {
      return std::nan("");
    }
    seconds += value * (text[used] == 'H' ? 3600 : text[used] == 'M' ? 60 : 1);
    text.remove_prefix(used + 1);
  }
  return seconds / 86400;
}

class Content final : public XmlHandler {
 public:
  std::vector<SheetCells> sheets;

  void begin(std::string_view name, const XmlAttributes& attributes) override {
    if (name == "style") {
      style_ = attributes["name"];
    } else if (name == "table-properties" && attributes["display"] == "false") {
      hidden_.insert(style_);
    } else if (name == "table") {
      begin_table(attributes);
    } else if (name == "table-row") {
      row_times_ = times(attributes["number-rows-repeated"]);
      column_ = 0;
      cells_.clear();
    } else if (name == "table-cell" || name == "covered-table-cell") {
      begin_cell(attributes);
    } else if (name == "annotation") {
      ++notes_;
    } else if (name == "p" && notes_ == 0) {
      text_ += text_.empty() ? "" : " ";
      in_text_ = true;
    } else if (name == "s" && in_text_) {
      text_ += ' ';
    }
  }

  void end(std::string_view name) override {
    if (name == "table") {
      --depth_;
    } else if (name == "table-row") {
      end_row();
    } else if (name == "table-cell" || name == "covered-table-cell") {
      end_cell();
    } else if (name == "annotation") {
      --notes_;
    } else if (name == "p") {
      in_text_ = false;
    }
  }

  void text(std::string_view part) override {
    if (in_text_ && notes_ == 0) {
      text_ += part;
    }
  }

 private:
  struct Cell {
    std::size_t column;
    std::string text;
    bool number;
  };

  void begin_table(const XmlAttributes& attributes) {
    // A table within a cell is none of the sheets.
    if (depth_++ == 0) {
      SheetCells& sheet = sheets.emplace_back();
      sheet.name = attributes["name"];
      sheet.hidden = hidden_.contains(std::string(attributes["style-name"]));
      row_ = 0;
    }
  }

  void begin_cell(const XmlAttributes& attributes) {
    cell_times_ = times(attributes["number-columns-repeated"]);
    const std::string_view type = attributes["value-type"];
    text_.clear();
    number_ = !type.empty() && type != "string";
    value_ = attributes["value"];
    if (type == "boolean") {
      value_ = attributes["boolean-value"] == "true" ? "1" : "0";
    } else if (type == "date") {
      value_ = attributes["date-value"];
      const bool has_clock = value_.find('T') != std::string::npos;
      std::ranges::replace(value_, 'T', ' ');
      value_ += has_clock ? "" : " 00:00:00";
    } else if (type == "time") {
      const double days = days_of_duration(attributes["time-value"]);
      value_ = cell_text(days, CellFormat::clock, false);
    } else if (type == "string") {
      value_ = attributes["string-value"];
    } else if (number_) {
      double value = 0;
      const auto [at, error] = std::from_chars(value_.data(), value_.data() + value_.size(), value);
      value_ =
          error == std::errc{} && at == value_.data() + value_.size() ? number_text(value) : "";
    }
  }

  void end_cell() {
    const std::string& text = value_.empty() ? text_ : value_;
    // The last cells of a row are empty, a thousand times.
    for (std::size_t i = 0; !text.empty() && i < std::min(cell_times_, most_repeated); ++i) {
      cells_.push_back({column_ + i, text, number_ && !value_.empty()});
    }
    column_ += cell_times_;
  }

  void end_row() {
    if (depth_ == 1) {
      for (std::size_t i = 0; !cells_.empty() && i < row_times_; ++i) {
        for (const Cell& cell : cells_) {
          sheets.back().add(row_ + i, cell.column, cell.text, cell.number);
        }
      }
      row_ += row_times_;
    }
    cells_.clear();
  }

  static constexpr std::size_t most_repeated = std::size_t{1} << 15;  ///< more than a sheet has

  std::set<std::string, std::less<>> hidden_;  ///< styles of hidden sheets
  std::string style_;
  std::vector<Cell> cells_;  ///< of the row
  int depth_ = 0, notes_ = 0;
  std::size_t row_ = 0, row_times_ = 1, column_ = 0, cell_times_ = 1;
  std::string text_, value_;
  bool number_ = false, in_text_ = false;
};

}  // namespace

std::vector<SheetCells> read_ods(const ZipArchive& archive) {
  if (archive.has("META-INF/manifest.xml")) {
    const std::string manifest = archive.beginning("META-INF/manifest.xml", std::size_t{1} << 20);
    if (manifest.find("encryption-data") != std::string::npos) {
      throw files::UserError("is encrypted; save it without a password");
    }
  }
  Content content;
  read_xml(archive, "content.xml", content);
  return content.sheets;
}

}  // namespace smaservo::hal
