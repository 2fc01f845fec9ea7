#pragma once
// A zip archive that is written: the same contents give the same bytes. FMUs are zip archives.

#include <cstdint>
#include <string>
#include <string_view>

namespace smaservo::fmu {

/// No dates, no owners, no zip64: below 4 GiB and 65536 files. host-sim has zlib for its traces; a
/// library for archives would be one more that every board has to install.
class ZipFile {
 public:
  /// Appends a file. `name` has forward slashes, and differs from all others.
  void add(const std::string& name, std::string_view content);
  /// The whole archive; nothing may be added afterwards. Throws UserError if it is too large.
  std::string finish();

 private:
  std::string all_, directory_;
  std::uint16_t files_ = 0;
};

}  // namespace smaservo::fmu
