#pragma once
// A trace in another format.

#include <cstdint>
#include <string>
#include <vector>

namespace smaservo::convert {

struct ConvertOptions {
  std::string in;     ///< CSV or MCAP, by its first bytes; "-": standard input
  std::string out;    ///< MCAP where it ends in .mcap, else CSV; "-": CSV on standard output
  std::string topic;  ///< of an MCAP file's channel; empty: /trace, or the only one
  bool compressed = true;
};

struct Converted {
  std::uint64_t rows = 0;
  std::size_t columns = 0;
  std::string cut_off;               ///< where an MCAP file ends that was not finished; else empty
  std::vector<std::string> remarks;  ///< what an MCAP file does not hold as the CSV text did
};

/// Keeps the columns, their order, and the text of each field; of a number that JSON does not write
/// so (".5"), its value. What is no number in a column of numbers is left out, and said in the
/// remarks. Throws UserError, also where no column has numbers.
Converted convert(const ConvertOptions& options);

}  // namespace smaservo::convert
