#include "model/files/text_table.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <numeric>

#include "model/files/message.hpp"
#include "model/files/wrapped.hpp"

namespace smaservo::files {
namespace {

using Json = nlohmann::ordered_json;
using TableColumns = std::vector<TextTable::Column>;

constexpr std::string_view gap = "  ";

// The table as people see it.

struct Printed {
  std::string text;
  bool marked;
};
using Line = std::vector<Printed>;

struct View {
  TableColumns columns;
  std::vector<Line> lines;  ///< without the headings
};

bool is_right(const TextTable::Column& column) {
  return !column.format.empty();
}

std::string text_of(const TextTable::Cell& cell, const TextTable::Column& column,
                    const std::string& nothing) {
  const auto text = [&](const auto& value) -> std::string {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::same_as<Value, std::string>) {
      return files::printable(value);
    } else if constexpr (std::same_as<Value, bool>) {
      return value ? "yes" : "no";
    } else if constexpr (std::integral<Value>) {
      return std::to_string(value);
    } else if constexpr (std::floating_point<Value>) {
      const std::string format = is_right(column) ? column.format : "{}";
      return std::isnan(value) ? nothing : fmt::format(fmt::runtime(format), column.scale * value);
    } else {
      return nothing;
    }
  };
  return std::visit(text, cell.value);
}

View view(const TableColumns& columns, const std::vector<TextTable::Row>& rows,
          const std::string& nothing) {
  View all{{}, std::vector<Line>(rows.size())};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const TextTable::Column& column = columns[i];
    if (column.heading.empty() && !column.key.empty()) {
      continue;
    }
    all.columns.push_back(column);
    all.columns.back().heading = files::printable(column.heading);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      all.lines[k].push_back({text_of(rows[k][i], column, nothing), rows[k][i].marked});
    }
  }
  return all;
}

/// A table on a terminal.
class Layout {
 public:
  /// Headings stand in one line each; with `breaks` they are broken to the width of the cells.
  Layout(const View& all, bool breaks) : all_(all), widths_(all.columns.size()) {
    for (const Line& line : all.lines) {
      for (std::size_t i = 0; i < line.size(); ++i) {
        widths_[i] = std::max(widths_[i], width_of(line[i].text));
        has_stars_ = has_stars_ || (line[i].marked && is_right(all.columns[i]));
      }
    }
    for (std::size_t i = 0; i < widths_.size(); ++i) {
      add_head(i, broken(all.columns[i].heading, breaks ? widths_[i] : std::string::npos));
    }
  }

  std::size_t width() const {
    const auto right = static_cast<std::size_t>(std::ranges::count_if(all_.columns, is_right));
    return std::accumulate(widths_.begin(), widths_.end(), gap.size() * (widths_.size() - 1)) +
           (has_stars_ ? right : 0);
  }

  std::string text() const {
    std::string text;
    for (std::size_t i = heads_.size(); i-- > 0;) {
      text += line_text(heads_[i]);
    }
    for (const Line& line : all_.lines) {
      text += line_text(line);
    }
    return text;
  }

 private:
  /// The last one of `lines` stands right above the cells.
  void add_head(std::size_t column, const std::vector<std::string>& lines) {
    for (std::size_t up = 0; up < lines.size() && !lines[up].empty(); ++up) {
      const std::string& text = lines[lines.size() - 1 - up];
      heads_.resize(std::max(heads_.size(), up + 1), Line(widths_.size()));
      heads_[up][column].text = text;
      widths_[column] = std::max(widths_[column], width_of(text));
    }
  }

  std::string line_text(const Line& line) const {
    std::string text;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const std::string blanks(widths_[i] - width_of(line[i].text), ' ');
      const char* star = !has_stars_ ? "" : line[i].marked ? "*" : " ";
      text += i == 0 ? "" : gap;
      text += is_right(all_.columns[i]) ? blanks + line[i].text + star : line[i].text + blanks;
    }
    return text.substr(0, text.find_last_not_of(' ') + 1) + "\n";
  }

  const View& all_;
  std::vector<std::size_t> widths_;
  std::vector<Line> heads_;  ///< lines of the headings, from the lowest one up
  bool has_stars_ = false;
};

// Markdown and HTML.

std::string markdown_line(const Line& line) {
  std::string text = "|";
  for (const auto& [cell, marked] : line) {
    text += marked ? " **" : " ";
    for (std::size_t i = 0; i < cell.size(); ++i) {
      const char next = i + 1 < cell.size() ? cell[i + 1] : ' ';
      const bool tag = std::isalpha(static_cast<unsigned char>(next)) != 0 || next == '/' ||
                       next == '!' || next == '?';
      text += cell[i] == '|' ? "\\|" : cell[i] == '<' && tag ? "&lt;" : std::string(1, cell[i]);
    }
    text += marked ? "** |" : " |";
  }
  return text + "\n";
}

std::string html_line(const Line& line, const char* tag) {
  std::string html = "<tr>";
  for (const auto& [cell, marked] : line) {
    html += fmt::format("<{0}{1}>{2}</{0}>", tag, marked ? " class=\"lost\"" : "", escaped(cell));
  }
  return html + "</tr>\n";
}

Line headings(const TableColumns& columns) {
  Line line;
  for (const TextTable::Column& column : columns) {
    line.push_back({column.heading, false});
  }
  return line;
}

}  // namespace

void TextTable::add(Row row) {
  row.resize(columns_.size());
  rows_.push_back(std::move(row));
}

std::string TextTable::text() const {
  const View all = view(columns_, rows_, nothing_);
  const Layout wide(all, false), narrow(all, true);
  const bool breaks = wide.width() > terminal_columns && narrow.width() <= terminal_columns;
  return (breaks ? narrow : wide).text();
}

std::string TextTable::markdown() const {
  const View all = view(columns_, rows_, nothing_);
  std::string text = markdown_line(headings(all.columns));
  for (const Column& column : all.columns) {
    text += is_right(column) ? "|--:" : "|---";
  }
  text += "|\n";
  for (const Line& line : all.lines) {
    text += markdown_line(line);
  }
  return text;
}

std::string TextTable::html() const {
  const View all = view(columns_, rows_, nothing_);
  const Line head = headings(all.columns);
  const bool has_head = !std::ranges::all_of(head, &std::string::empty, &Printed::text);
  // A browser repeats <thead> on each printed page.
  std::string html = "<table>\n";
  if (has_head) {
    html += "<thead>" + html_line(head, "th") + "</thead>\n";
  }
  for (const Line& line : all.lines) {
    html += html_line(line, "td");
  }
  return html + "</table>\n";
}

Json TextTable::json() const {
  Json list = Json::array();
  for (const Row& row : rows_) {
    Json object;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (!columns_[i].key.empty()) {
        std::visit([&](const auto& value) { object[columns_[i].key] = value; }, row[i].value);
      }
    }
    list.push_back(std::move(object));
  }
  return list;
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : files::printable_lines(text)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string json_text(const Json& json, int indent) {
  return files::printable_json(json.dump(indent, ' ', false, Json::error_handler_t::replace)) +
         "\n";
}

}  // namespace smaservo::files
