#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hal/replay/trace.hpp"

namespace smaservo::convert {

/// The names of a table's columns in this project's dialect, as the header of CSV without its line
/// end.
std::string own_header(const hal::TraceReader& trace);
/// Adds a row that the reader has given to `text`, as own_header() has the columns, without a line
/// end: each field is the text that it was, but for numbers in units that need a factor.
void add_own_row(const hal::TraceReader& trace, const hal::TraceRow& row, std::string& text);

/// The rows of another program's table as CSV in this project's dialect: names as `current_mA`,
/// numbers with a point, each field's text otherwise unchanged.
class OwnRows {
 public:
  /// Throws TraceError where the file cannot be read or a row is bad.
  OwnRows(const std::string& path, const std::vector<std::string>& renames);

  /// Whether the file is compressed, or not of this project's dialect.
  bool is_foreign() const { return trace_.is_packed() || !trace_.read_as().empty(); }
  const hal::TraceReader& trace() const { return trace_; }
  /// Returns the number of bytes; 0 at the end.
  std::size_t read(char* to, std::size_t room);

 private:
  hal::TraceReader trace_;
  std::string text_;
  std::size_t given_ = 0;
};

}  // namespace smaservo::convert
