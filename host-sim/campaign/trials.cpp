#include "host-sim/campaign/trials.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace smaservo::campaign {
namespace {

std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) {
    return text;
  }
  std::string quoted = "\"";
  for (const char c : text) {
    quoted += c == '"' ? "\"\"" : std::string(1, c);
  }
  return quoted + '"';
}

struct AsText {
  std::string operator()(std::uint64_t number) const { return fmt::to_string(number); }
  std::string operator()(double number) const {
    return std::isnan(number) ? "" : fmt::format("{}", number);
  }
  std::string operator()(const std::string& text) const { return csv_text(text); }
};

}  // namespace

std::string yes_or_no(bool value) {
  return value ? "true" : "false";
}

std::string row_text(const std::vector<Column>& columns, const Row& row) {
  std::size_t width = 0;
  for (const Column& column : columns) {
    width = std::max(width, column.name.size());
  }
  std::string text;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::string cell = std::visit(AsText{}, row[i]);
    text += cell.empty() ? "" : fmt::format("{:{}}  {}\n", columns[i].name, width, cell);
  }
  return text;
}

std::string csv_head(const std::vector<Column>& columns) {
  std::string line = "trial";
  for (const Column& column : columns) {
    line += ',' + csv_text(column.name);
  }
  return line + '\n';
}

std::string csv_line(std::uint64_t index, const Row& row) {
  std::string line = fmt::to_string(index);
  for (const Value& value : row) {
    line += ',' + std::visit(AsText{}, value);
  }
  return line + '\n';
}

}  // namespace smaservo::campaign
