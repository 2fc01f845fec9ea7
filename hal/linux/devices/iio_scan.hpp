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
  unsigned bits;     ///< of the value, 1 to 64
  unsigned storage;  ///< bits in the buffer: 8, 16, 32 or 64
  unsigned shift;    ///< to the right, before the bits above `bits` are cut off

  bool operator==(const ScanType&) const = default;
};
/// nullopt where it is no such text, or one of repeated elements, which are not supported.
std::optional<ScanType> parse_scan_type(std::string_view text);

struct ScanElement {
  std::string name;  ///< "in_voltage0"
  unsigned index;    ///< its place in the scan
  ScanType type;
};

struct PlacedElement {
  ScanType type;
  std::size_t offset;  ///< bytes from the beginning of a scan
};

/// In a scan the elements are in the order of their indices, each aligned to its own size.
struct ScanLayout {
  std::vector<PlacedElement> elements;  ///< in the order of lay_out()'s argument
  std::size_t size;                     ///< of one scan
};
ScanLayout lay_out(std::span<const ScanElement> elements);

std::int64_t sample_of(const PlacedElement& element, std::span<const std::byte> scan);

}  // namespace smaservo::hal
