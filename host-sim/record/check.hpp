#pragma once
// Whether a folder that somebody else has made is whole and usable.

#include <cstdint>
#include <string>
#include <vector>

namespace smaservo::record {

struct Checked {
  std::vector<std::string> faults;  ///< each names its file
  std::vector<std::string> notes;   ///< what is not wrong, but to be known
  std::size_t runs = 0;
  std::uint64_t rows = 0;
};

/// Looks at card, wire, checksums and every run. Links and all that is no plain file are faults and
/// are not opened, so nothing outside of the folder is read. Checks in `allowed` give notes. Throws
/// UserError where the path is no folder, and soon after a signal (EndBySignal).
Checked check_folder(const std::string& path, const std::vector<std::string>& allowed);

}  // namespace smaservo::record
