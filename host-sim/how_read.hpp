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

/// After the last row: says how often the header stood again among the rows, and how many lines
/// were no rows.
inline void say_what_was_skipped(const std::string& path, const hal::TraceReader& trace) {
  const std::string name = path == "-" ? "standard input" : path;
  const auto say = [&](std::uint64_t count, const char* one, const char* many,
                       const std::string& first) {
    if (count > 0) {
      files::complain("host-sim",
                      fmt::format("{}: {} {} among the rows {} skipped{}", name, count,
                                  count == 1 ? one : many, count == 1 ? "was" : "were", first));
    }
  };
  say(trace.repeated_headers(), "header", "headers", "");
  say(trace.strays(), "line that is no row", "lines that are no rows", "; " + trace.first_stray());
}

}  // namespace smaservo
