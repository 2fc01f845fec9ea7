#include "host-sim/fmu/zip_file.hpp"

#include <limits>
#include <stdexcept>
#include <zlib.h>

#include "model/files/error.hpp"

namespace smaservo::fmu {
namespace {

/// Appends numbers as zip has them, the lowest byte first.
class Record {
 public:
  explicit Record(std::string& to) : to_(to) {}
  Record& u16(std::uint32_t value) { return bytes(value, 2); }
  Record& u32(std::uint32_t value) { return bytes(value, 4); }

 private:
  Record& bytes(std::uint32_t value, int count) {
    for (int i = 0; i < count; ++i) {
      to_ += static_cast<char>(value >> (8 * i) & 0xFFU);
    }
    return *this;
  }
  std::string& to_;
};

/// Without the frame that zlib puts around its data.
std::string deflated(std::string_view content) {
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, -MAX_WBITS, MAX_MEM_LEVEL,
                   Z_DEFAULT_STRATEGY) != Z_OK) {
    throw std::bad_alloc();
  }
  std::string packed(deflateBound(&stream, content.size()), '\0');
  // zlib takes what it only reads as not const.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));  // NOLINT
  stream.avail_in = static_cast<uInt>(content.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());  // NOLINT(*-reinterpret-cast)
  stream.avail_out = static_cast<uInt>(packed.size());
  const int result = deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) {
    throw std::logic_error("deflate");
  }
  return packed;
}

constexpr std::uint32_t version = 20;  // of zip: folders and deflate
constexpr std::uint32_t made_on_unix = 3 << 8;
constexpr std::uint32_t deflate_method = 8;
constexpr std::uint32_t utf8_names = 1 << 11;
constexpr std::uint32_t no_time = 0;
constexpr std::uint32_t no_date = (1 << 5) + 1;  // 1980-01-01
constexpr std::uint32_t readable_file = 0100644U << 16;

}  // namespace

void ZipFile::add(const std::string& name, std::string_view content) {
  constexpr std::size_t most = std::numeric_limits<std::uint32_t>::max() / 2;
  if (content.size() > most || all_.size() > most ||
      files_ == std::numeric_limits<std::uint16_t>::max()) {
    throw files::UserError("a zip archive cannot hold so much");
  }
  const std::string packed = deflated(content);
  const auto checksum = static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(content.data()),  // NOLINT(*-reinterpret-cast)
            static_cast<uInt>(content.size())));
  const auto common = [&](std::string& to) {
    Record(to)
        .u16(version)
        .u16(utf8_names)
        .u16(deflate_method)
        .u16(no_time)
        .u16(no_date)
        .u32(checksum)
        .u32(static_cast<std::uint32_t>(packed.size()))
        .u32(static_cast<std::uint32_t>(content.size()))
        .u16(static_cast<std::uint32_t>(name.size()))
        .u16(0);
  };
  const auto offset = static_cast<std::uint32_t>(all_.size());
  Record(all_).u32(0x04034B50);
  common(all_);
  all_ += name;
  all_ += packed;
  Record(directory_).u32(0x02014B50).u16(made_on_unix + version);
  common(directory_);
  // No comment, on disk 0, no attributes of the content.
  Record(directory_).u16(0).u16(0).u16(0).u32(readable_file).u32(offset);
  directory_ += name;
  ++files_;
}

std::string ZipFile::finish() {
  const auto offset = static_cast<std::uint32_t>(all_.size());
  all_ += directory_;
  Record(all_)
      .u32(0x06054B50)
      .u16(0)
      .u16(0)
      .u16(files_)
      .u16(files_)
      .u32(static_cast<std::uint32_t>(directory_.size()))
      .u32(offset)
      .u16(0);
  return std::move(all_);
}

}  // namespace smaservo::fmu
