#include "model/files/wrapped.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace smaservo::files {
namespace {

constexpr std::size_t description_column = 30;

bool is_continuation(char c) {
  return (static_cast<unsigned char>(c) & 0xC0U) == 0x80;
}

bool has_description(std::string_view line) {
  return line.size() > description_column && line.starts_with("  ") &&
         line[description_column - 1] == ' ' && line[description_column] != ' ';
}

/// An option with many choices, or with many that it excludes; its description is on the next line.
std::string broken_name(std::string_view name) {
  constexpr std::size_t indent = 6;
  std::string spaced;
  for (const char c : name) {
    spaced += c;
    spaced += c == ',' ? " " : "";
  }
  return fmt::format("  {}\n", fmt::join(broken(spaced, terminal_columns - indent),
                                         "\n" + std::string(indent, ' ')));
}

}  // namespace

std::size_t width_of(std::string_view text) {
  return text.size() - static_cast<std::size_t>(std::ranges::count_if(text, is_continuation));
}

std::vector<std::string> broken(std::string_view text, std::size_t width) {
  std::vector<std::string> lines{""};
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(std::min(word.size() + 1, text.size()));
    if (lines.back().empty()) {
      lines.back() = word;
    } else if (width_of(lines.back()) + 1 + width_of(word) <= width) {
      lines.back().append(" ").append(word);
    } else {
      lines.emplace_back(word);
    }
  }
  return lines;
}

std::string paragraph(std::string_view heading, std::string_view text, std::size_t indent) {
  return fmt::format(
      "{:<{}}{}\n", heading, indent,
      fmt::join(broken(text, terminal_columns - indent), "\n" + std::string(indent, ' ')));
}

std::string wrapped_help(std::string_view help) {
  std::string all;
  while (!help.empty()) {
    const std::string_view line = help.substr(0, help.find('\n'));
    const bool ends = line.size() < help.size();
    help.remove_prefix(line.size() + (ends ? 1 : 0));
    if (width_of(line) <= terminal_columns) {
      all += line;
      all += ends ? "\n" : "";
    } else if (has_description(line)) {
      all += paragraph(line.substr(0, description_column), line.substr(description_column),
                       description_column);
    } else if (line.starts_with("  -")) {
      all += broken_name(line.substr(2));
    } else {
      all += paragraph("", line, 0);
    }
  }
  return all;
}

}  // namespace smaservo::files
