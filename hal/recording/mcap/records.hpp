#pragma once
// How MCAP files store things (https://mcap.dev/spec): a file is its magic bytes, records and the
// magic bytes again. A record is a byte for its kind, its length (8 bytes), and its content.

#include <cstdint>
#include <string>
#include <string_view>

#include "model/files/error.hpp"

namespace smaservo::hal::mcap {

inline constexpr std::string_view magic{"\x89MCAP0\r\n", 8};

enum class Op : std::uint8_t {
  none = 0x00,  ///< no record has this kind
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  attachment = 0x09,
  attachment_index = 0x0A,
  statistics = 0x0B,
  metadata = 0x0C,
  metadata_index = 0x0D,
  summary_offset = 0x0E,
  data_end = 0x0F
};

/// Bytes of a record before its content.
inline constexpr std::size_t record_head = 9;

/// Names of the compressions of chunks; an uncompressed chunk has the name "".
inline constexpr std::string_view zstd = "zstd";
inline constexpr std::string_view lz4 = "lz4";

/// A file that is not as the format demands. The text begins with the offset in bytes.
class Malformed : public files::UserError {
 public:
  Malformed(std::uint64_t offset, std::string_view what);
};

/// Appends a number, the lowest byte first.
template <class T>
void put(std::string& to, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    to += static_cast<char>(value >> (8 * i) & 0xFFU);
  }
}
/// Appends a text with its length before it (4 bytes).
void put_text(std::string& to, std::string_view text);

/// The content of a record, read from its beginning. All functions throw Malformed if the content
/// is too short.
class Content {
 public:
  /// `offset` is the position of the content in the file; `what` names the record in messages.
  Content(std::string_view bytes, std::uint64_t offset, std::string_view what)
      : rest_(bytes), offset_(offset), what_(what) {}

  template <class T>
  T number() {
    const std::string_view bytes = take(sizeof(T));
    T value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      value =
          static_cast<T>(value | static_cast<T>(T{static_cast<std::uint8_t>(bytes[i])} << (8 * i)));
    }
    return value;
  }
  /// A text that is preceded by its length (4 bytes).
  std::string_view text() { return take(number<std::uint32_t>()); }
  std::string_view take(std::uint64_t size);

  std::string_view rest() const { return rest_; }
  std::uint64_t offset() const { return offset_; }

 private:
  std::string_view rest_;
  std::uint64_t offset_;
  std::string_view what_;
};

/// Continues the CRC-32 `crc` (0: no bytes yet) with these bytes.
std::uint32_t crc_of(std::string_view bytes, std::uint32_t crc = 0);

}  // namespace smaservo::hal::mcap
