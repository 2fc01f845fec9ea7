#pragma once

#include <fmt/format.h>
#include <string>

#include "hal/replay/trace.hpp"
#include "model/files/message.hpp"

namespace smaservo {

/// Says on the standard error output how the table of another program is read, and what columns may
/// mean that are not taken. Nothing is said of a file of this project's dialect.
inline void say_how_read(const std::string& path, const hal::TraceReader& trace) {
  const std::string name = path == "-" ? "standard input" : path;
  if (const std::string as = trace.read_as(); !as.empty()) {
    files::complain("host-sim", name + ": read as " + as);
  }
  for (const std::string& hint : trace.hints()) {
    files::complain("host-sim", name + ": " + hint);
  }
}

/// After the last row: says how often the header stood again among the rows.
inline void say_what_was_skipped(const std::string& path, const hal::TraceReader& trace) {
  const std::uint64_t headers = trace.repeated_headers();
  if (headers > 0) {
    files::complain(
        "host-sim",
        fmt::format("{}: {} among the rows {} skipped", path == "-" ? "standard input" : path,
                    headers == 1 ? "1 header" : fmt::format("{} headers", headers),
                    headers == 1 ? "was" : "were"));
  }
}

}  // namespace smaservo
