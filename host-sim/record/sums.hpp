#pragma once
// Lists of checksums as `sha256sum -c` reads them.

#include <string>
#include <string_view>
#include <vector>

namespace smaservo::record {

/// 64 hexadecimal digits, of a whole file. Throws UserError if it cannot be read.
std::string sha256_of_file(const std::string& path);

struct Sum {
  std::string hex, path;  ///< path: relative to the list's folder
};
/// Whether a path stays in the folder, links apart: none of its parts is "..", "." or empty.
bool stays_inside(const std::string& path);

/// "HEX  PATH", a line for each.
std::string sums_text(const std::vector<Sum>& sums);
/// Also takes the second blank as the star of binary mode. A line that is none is added to
/// `faults`, which begin with "ORIGIN:LINE: ".
std::vector<Sum> parse_sums(std::string_view text, const std::string& origin,
                            std::vector<std::string>& faults);

}  // namespace smaservo::record
