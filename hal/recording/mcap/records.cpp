#include "hal/recording/mcap/records.hpp"

#include <fmt/format.h>
#include <zlib.h>

namespace smaservo::hal::mcap {

Malformed::Malformed(std::uint64_t offset, std::string_view what)
    : files::UserError(fmt::format("byte {}: {}", offset, what)) {}

void put_text(std::string& to, std::string_view text) {
  put(to, static_cast<std::uint32_t>(text.size()));
  to += text;
}

std::string_view Content::take(std::uint64_t size) {
  if (size > rest_.size()) {
    throw Malformed(offset_, fmt::format("{} has {} bytes left where {} must follow", what_,
                                         rest_.size(), size));
  }
  const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(size));
  rest_.remove_prefix(taken.size());
  offset_ += size;
  return taken;
}

std::uint32_t crc_of(std::string_view bytes, std::uint32_t crc) {
  // NOLINTNEXTLINE(*-reinterpret-cast): the same bytes as zlib's own type
  const auto* const data = reinterpret_cast<const Bytef*>(bytes.data());
  return static_cast<std::uint32_t>(crc32_z(crc, data, bytes.size()));
}

}  // namespace smaservo::hal::mcap
