#pragma once
// Scan elements of the kernel's IIO buffers: how samples lie in what /dev/iio:deviceN gives
// (Documentation/iio/iio_devbuf.rst).

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace smaservo::hal {

/// "le:s24/32>>8"
struct ScanType {
  bool big_endian;
  bool is_signed;
  unsigned bits;     ///< that count, 1 to 64
  unsigned storage;  ///< bits that it takes: 8, 16, 32 or 64
  unsigned shift;    ///< to the right, before the upper bits are cut off

  bool operator==(const ScanType&) const = default;
};
/// Nothing where it is no such text. Repeated elements are none that we read.
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

/// Elements in the order of their indices, each aligned to its own size.
struct ScanLayout {
  std::vector<PlacedElement> elements;  ///< in the order that they were given in
  std::size_t size;                     ///< of one scan
};
ScanLayout lay_out(std::span<const ScanElement> elements);

std::int64_t sample_of(const PlacedElement& element, std::span<const std::byte> scan);

}  // namespace smaservo::hal
