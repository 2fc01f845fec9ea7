#pragma once
// The layout of samples in the scans that are read from /dev/iio:deviceN (the kernel's
// Documentation/iio/iio_devbuf.rst).

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace smaservo::hal {

/// Format of a sample, in the kernel's text "le:s24/32>>8".
struct ScanType {
  bool big_endian;
  bool is_signed;
  unsigned bits;     ///< bits of the value, 1 to 64
  unsigned storage;  ///< bits of the sample in the buffer: 8, 16, 32 or 64
  unsigned shift;  ///< number of bits by which a sample is shifted to the right before it is cut to
                   ///< `bits`

  bool operator==(const ScanType&) const = default;
};
/// nullopt if the text is not such a format, or has repeated elements, which are not supported.
std::optional<ScanType> parse_scan_type(std::string_view text);

struct ScanElement {
  std::string name;  ///< "in_voltage0"
  unsigned index;    ///< position in the scan
  ScanType type;
};

struct PlacedElement {
  ScanType type;
  std::size_t offset;  ///< position in bytes from the beginning of a scan
};

/// The elements of a scan are in the order of their indices, each aligned to its own size.
struct ScanLayout {
  std::vector<PlacedElement> elements;  ///< in the order of the argument of lay_out()
  std::size_t size;                     ///< bytes of one scan
};
ScanLayout lay_out(std::span<const ScanElement> elements);

std::int64_t sample_of(const PlacedElement& element, std::span<const std::byte> scan);

}  // namespace smaservo::hal
