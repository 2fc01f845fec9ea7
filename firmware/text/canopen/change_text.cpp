#include "firmware/text/canopen/change_text.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "firmware/text/canopen/abort_text.hpp"
#include "firmware/text/canopen/objects.hpp"

namespace smaservo::text {
namespace {

using canopen::Abort;
using canopen::Source;

constexpr Key tuning_key{0x2102, 1};
constexpr std::array<const char*, 6> sources{"SDO",        "PDO",       "LSS",
                                             "the device", "the image", "the settings file"};
constexpr std::array<const char*, 5> tuning_commands{"none", "begin", "try", "commit", "revert"};

const char* source_of(const canopen::LoggedChange& change) {
  const auto i = static_cast<std::size_t>(change.source);
  return i < sources.size() ? sources.at(i) : "?";
}

std::string text_of(const KnownObject& object, std::uint32_t bits) {
  std::array<std::uint8_t, 4> bytes{};
  canopen::put_number(bytes, bits);
  const std::size_t size = canopen::size_of(object.type);
  return value_text(object, std::span(bytes).first(size == 0 ? 4 : std::min<std::size_t>(size, 4)));
}

/// The value that was refused; in hexadecimal digits where the number of bytes was wrong, as these
/// are no value of the object.
std::string wanted_text(const KnownObject& object, const canopen::LoggedChange& change) {
  const bool whole = change.result != Abort::too_long && change.result != Abort::too_short;
  return whole ? text_of(object, change.value) : fmt::format("{:X}h", change.value);
}

std::string refusal_text(Abort result) {
  const auto code = static_cast<std::uint32_t>(result);
  return fmt::format("is refused: {} (abort {:08X}h)", abort_text(code), code);
}

std::string tuning_text(const canopen::LoggedChange& change) {
  const char* const command =
      change.value < tuning_commands.size() ? tuning_commands.at(change.value) : "unknown command";
  if (change.result != Abort::none) {
    return fmt::format("tuning: {} {}", command, refusal_text(change.result));
  }
  if (change.source == Source::device) {
    return change.value == 0 ? "tuning: the trial has ended, all is reverted"
                             : "tuning: the client has gone, all is reverted";
  }
  return fmt::format("tuning: {}", command);
}

}  // namespace

std::string change_text(const canopen::LoggedChange& change) {
  if (change.key == tuning_key) {
    return tuning_text(change);
  }
  const KnownObject object =
      find_object(fmt::format("{:04X}:{}", change.key.index, change.key.sub));
  if (change.result == Abort::none) {
    return fmt::format("{}: {} -> {}, by {}", title(object), text_of(object, change.before),
                       text_of(object, change.value), source_of(change));
  }
  return fmt::format("{}: stays {}; {} by {} {}", title(object), text_of(object, change.before),
                     wanted_text(object, change), source_of(change), refusal_text(change.result));
}

canopen::LoggedChange change_of(std::span<const std::uint8_t> bytes) {
  const auto number = [&](std::size_t at, std::size_t size) {
    return static_cast<std::uint32_t>(canopen::take_number(bytes.subspan(at, size)));
  };
  return {number(0, 4),
          {static_cast<std::uint16_t>(number(4, 2)), bytes[6]},
          static_cast<Source>(bytes[7]),
          number(8, 4),
          number(12, 4),
          static_cast<Abort>(number(16, 4))};
}

}  // namespace smaservo::text
