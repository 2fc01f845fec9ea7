#pragma once
// Converts a trace to another format.

#include <cstdint>
#include <string>
#include <vector>

namespace smaservo::convert {

struct ConvertOptions {
  std::string in;   ///< a table as text or MCAP, told by its content; "-": standard input
  std::string out;  ///< MCAP if the name ends in .mcap, otherwise CSV; "-": CSV on standard output
  std::string topic;  ///< topic of an MCAP file's channel; empty: /trace, or the only one
  bool compressed = true;
  std::vector<std::string>
      renames;  ///< of another program's columns, as hal::TraceOptions has them
};

struct Converted {
  std::uint64_t rows = 0;
  std::size_t columns = 0;
  std::string cut_off;               ///< where an unfinished MCAP file ends; otherwise empty
  std::vector<std::string> remarks;  ///< how an MCAP file differs from the CSV text
};

/// A file that is another program's table (hal/replay/README.md) becomes one of this project's
/// dialect. Keeps the columns, their order, and the text of each field; of a number that JSON
/// writes in another way (".5"), only the value. Values that are not numbers are left out of a
/// column of numbers, which the remarks report. Throws UserError, also if no column has numbers.
Converted convert(const ConvertOptions& options);

}  // namespace smaservo::convert
