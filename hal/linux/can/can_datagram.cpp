#include "hal/linux/can/can_datagram.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace smaservo::hal {
namespace {

using nlohmann::json;

constexpr std::uint32_t largest_standard_id = 0x7FF;
constexpr std::uint32_t largest_extended_id = 0x1FFF'FFFF;
constexpr std::uint64_t max_data = 8;

/// The value of a flag; false if it is missing, nullopt if the value is not a flag.
std::optional<bool> flag(const json& map, const char* key) {
  const auto found = map.find(key);
  if (found == map.end()) {
    return false;
  }
  if (!found->is_boolean()) {
    return std::nullopt;
  }
  return found->get<bool>();
}

/// The value of a whole number; nullopt if it is missing, of another kind or above `max`.
std::optional<std::uint64_t> number(const json& map, const char* key, std::uint64_t max) {
  const auto found = map.find(key);
  if (found == map.end() || !found->is_number_unsigned()) {
    return std::nullopt;
  }
  const auto value = found->get<std::uint64_t>();
  return value <= max ? std::optional(value) : std::nullopt;
}

/// Reads the data, which a remote frame does not need; false if they are malformed.
bool read_data(const json& map, CanFrame& frame) {
  const auto found = map.find("data");
  if (frame.remote) {
    return true;
  }
  if (found == map.end() || found->is_null()) {
    return frame.length == 0;
  }
  if (!found->is_binary() || found->get_binary().size() != frame.length) {
    return false;
  }
  std::ranges::copy(found->get_binary(), frame.data.begin());
  return true;
}

}  // namespace

std::vector<std::uint8_t> to_datagram(const CanFrame& frame, double time_s) {
  const std::span<const std::uint8_t> data =
      frame.remote ? std::span<const std::uint8_t>() : frame.payload();
  const json map = {
      {"timestamp", time_s},
      {"arbitration_id", frame.id},
      {"is_extended_id", frame.extended},
      {"is_remote_frame", frame.remote},
      {"is_error_frame", false},
      {"channel", nullptr},
      {"dlc", frame.length},
      {"data", json::binary({data.begin(), data.end()})},
      {"is_fd", false},
      {"bitrate_switch", false},
      {"error_state_indicator", false},
  };
  return json::to_msgpack(map);
}

std::optional<CanFrame> from_datagram(std::span<const std::uint8_t> datagram) {
  const json map = json::from_msgpack(datagram, true, false);
  if (!map.is_object()) {
    return std::nullopt;
  }
  const std::optional<bool> extended = flag(map, "is_extended_id");
  const std::optional<bool> remote = flag(map, "is_remote_frame");
  if (!extended || !remote || flag(map, "is_error_frame") != false || flag(map, "is_fd") != false) {
    return std::nullopt;
  }
  const auto id =
      number(map, "arbitration_id", *extended ? largest_extended_id : largest_standard_id);
  const auto length = number(map, "dlc", max_data);
  if (!id || !length) {
    return std::nullopt;
  }
  CanFrame frame;
  frame.id = static_cast<std::uint32_t>(*id);
  frame.extended = *extended;
  frame.remote = *remote;
  frame.length = static_cast<std::uint8_t>(*length);
  return read_data(map, frame) ? std::optional(frame) : std::nullopt;
}

}  // namespace smaservo::hal
