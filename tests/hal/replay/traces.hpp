#pragma once
// Reading a trace that a test has as text.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hal/replay/trace.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test {

struct TraceContents {
  std::vector<std::array<double, hal::column_count>> rows;
  std::vector<std::string> texts;
  std::vector<std::string> complaints;
  std::uint64_t skipped = 0;

  double at(std::size_t row, hal::Column column) const {
    return rows.at(row)[static_cast<std::size_t>(column)];
  }
};

inline TraceContents read_all(hal::TraceReader& reader) {
  TraceContents all;
  hal::TraceRow row{};
  while (reader.next(row)) {
    all.rows.push_back(row.values);
    all.texts.emplace_back(row.text);
  }
  all.complaints = reader.complaints();
  all.skipped = reader.skipped();
  return all;
}

inline TraceContents read_trace(std::string_view text, const hal::TraceOptions& options = {}) {
  const TemporaryFolder folder;
  hal::TraceReader reader(folder.write("trace.csv", text), options);
  return read_all(reader);
}

/// The message that refuses a trace, without the file's name; empty if the trace is read.
inline std::string refusal(std::string_view text, const hal::TraceOptions& options = {}) {
  const TemporaryFolder folder;
  const std::string path = folder.write("trace.csv", text);
  try {
    hal::TraceReader reader(path, options);
    read_all(reader);
  } catch (const hal::TraceError& error) {
    const std::string message = error.what();
    return message.starts_with(path + ": ") ? message.substr(path.size() + 2)
                                            : "without the file's name: " + message;
  }
  return "";
}

}  // namespace smaservo::test
